// Fine checks of paths on which the triangles of contact keep apart, but the curved surfaces of
// shells over these triangles might not.
#pragma once

#include <compare>
#include <optional>
#include <span>
#include <vector>

#include "sim/contact/surface_contact.h"
#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// Divides each triangle of a shell in 16 smaller ones, whose corners lie on the curved surface. The
// surface leaves these by a sixteenth of what it leaves the whole triangle by.
class CurvedPaths {
 public:
  // The straight paths of all particles and all surface points, m. Points of obstacles that have a
  // pose need not be placed.
  struct Path {
    std::span<const Vec3> start_particles, end_particles;
    const PlacedPoints &start, &end;
  };

  explicit CurvedPaths(const Scene& scene);

  // Returns a fault of kind curved unless the surfaces around all `pairs` provably stay apart on
  // the path and on all paths that deviate from it by at most `stray`. `curve` bounds the distances
  // between the surfaces and their triangles. Every piece of surface is checked that has a feature
  // of a pair for a side or corner, unless both pieces share a point. Cost: up to 1400 checks of
  // features per pair of triangles.
  [[nodiscard]] std::optional<ContactFault> find_fault(std::span<const OpenPair> pairs,
                                                       const Path& path, const PointStray& stray,
                                                       const CurveStray& curve,
                                                       const RigidObstacles& obstacles);

 private:
  // A piece of surface over a triangle, in smaller triangles, or a sphere: a point from which the
  // surface deviates by the radius.
  struct Piece {
    std::vector<Vec3> start, end;  // corners, m
    int division = 1;              // number of parts of each side; 0 for a point
    double deviation = 0;          // m, bound of the distance between surface and triangles
  };
  struct Triangle {
    int body = 0, number = 0;  // number in the mesh of the body, or of the sphere in its group
    auto operator<=>(const Triangle&) const = default;  // NOLINT(modernize-use-nullptr)
  };

  void list_triangles(std::span<const int> points, std::vector<Triangle>& found) const;
  Piece piece_of(const Triangle& triangle, const Path& path, const CurveStray& curve,
                 const RigidObstacles& obstacles) const;
  std::vector<SplineSurface::Place> places_of(const Triangle& triangle) const;
  bool touch(const Triangle& one, const Triangle& other) const;

  const Scene& scene_;
  // The triangles around each surface point: those of point p are triangles_[first_[p]] ..
  // triangles_[first_[p + 1] - 1], by their numbers in the mesh of the body.
  std::vector<int> first_, triangles_;
};

}  // namespace weft::sim
