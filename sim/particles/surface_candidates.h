// The triangles of an obstacle near each sphere.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/particles/sphere_surfaces.h"

namespace weft::sim {

// A triangle near a sphere, and the distance of the surfaces (m) where the list was made.
struct NearTriangle {
  int triangle;
  double gap;
};

// Lists of triangles of one obstacle, one per sphere. A list holds all triangles whose gap is at
// most its margin at the place where it was made, and possibly a few others. By the triangle
// inequality it holds all whose gap is at most the margin less the distance moved since. Each list
// is therefore made anew only once its own sphere has moved far enough.
class SurfaceCandidates {
 public:
  // The surface and the radii must outlive the object.
  SurfaceCandidates(const ObstacleSurface& surface, std::span<const double> radii);

  // Makes the list of the sphere complete for gaps of at most `need` (m) at `place`, which is in
  // the frame of the surface. A new list gets at least the margin `wish` (m), >= need. Returns the
  // number of bounds that were compared.
  std::int64_t cover(int sphere, const Vec3& place, double need, double wish);
  // Measures the triangles of the list again if the sphere has moved by more than `far` (m). The
  // list then counts as made at `place`, with a smaller margin.
  void measure(int sphere, const Vec3& place, double far);
  // Returns the list of the sphere, by ascending triangles.
  std::span<const NearTriangle> of(int sphere) const {
    const List& list = lists_[sphere];
    return {pool_.data() + list.first, pool_.data() + list.end};
  }
  // Returns the distance (m) of `place` from that where the list was made.
  double moved(int sphere, const Vec3& place) const {
    return (place - lists_[sphere].place).norm();
  }
  // Returns the least gap (m) of the list where it was made, or its margin if it is empty.
  double least_gap(int sphere) const { return lists_[sphere].least_gap; }
  // Returns the number of lists made so far.
  std::int64_t lists_made() const { return lists_made_; }

 private:
  struct List {
    Vec3 place{0, 0, 0};  // m, where it was made
    double margin = -1;   // m
    double least_gap = 0;
    std::size_t first = 0, end = 0;  // in pool_
  };

  double gap(int sphere, int triangle, const Vec3& place) const;
  double distance_to_box(const Vec3& place) const;
  void fill(int sphere);
  void compact();

  const ObstacleSurface& surface_;
  std::span<const double> radii_;
  Vec3 low_, high_;  // m, bounds of the surface
  std::vector<List> lists_;
  std::vector<NearTriangle> pool_, spare_;
  std::size_t live_ = 0;  // entries of pool_ that belong to a list
  std::vector<int> found_;
  std::int64_t lists_made_ = 0;
};

}  // namespace weft::sim
