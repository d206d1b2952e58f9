// Surfaces of B-splines whose control points are the particles of an image.
#pragma once

#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/scene/spline_axis.h"
#include "sim/scene/surface_map.h"

namespace weft::sim {

// The surface of a body, with one tensor-product spline per patch of its atlas. The parameter u
// grows with the column, v with the row. Patches that share a border of particles share the curve
// there.
class SplineSurface {
 public:
  using Vec3 = Eigen::Vector3d;
  struct Patch {
    SplineAxis u, v;
    int elements() const { return u.elements() * v.elements(); }
  };
  // The parameters of a point of a patch.
  struct Place {
    int patch = 0;
    double u = 0, v = 0;
  };

  // The control points on which a point depends, with the values of their basis functions at the
  // point and the derivatives of these functions by u and v.
  struct Point {
    std::vector<int> control_points;
    std::vector<double> value, slope_u, slope_v;

    static Vec3 sum(const std::vector<double>& factors, const std::vector<int>& control_points,
                    std::span<const Vec3> x) {
      Vec3 total = Vec3::Zero();
      for (std::size_t i = 0; i < factors.size(); ++i) total += factors[i] * x[control_points[i]];
      return total;
    }
    // tangent_u() and tangent_v() return the tangents (m) along u and v, and position() the point
    // (m). `x` has the positions of all control points of the surface (m).
    Vec3 tangent_u(std::span<const Vec3> x) const { return sum(slope_u, control_points, x); }
    Vec3 tangent_v(std::span<const Vec3> x) const { return sum(slope_v, control_points, x); }
    Vec3 position(std::span<const Vec3> x) const { return sum(value, control_points, x); }
  };

  // Precondition: each axis has at least SplineAxis::least_control_points(degree) control points.
  SplineSurface(const bsi::Atlas& atlas, int degree);

  int degree() const { return degree_; }
  int nodes_per_element() const { return (degree_ + 1) * (degree_ + 1); }
  const std::vector<Patch>& patches() const { return patches_; }
  // Returns the control points of an element (local indices of particles), row by row.
  std::vector<int> control_points(const bsi::Atlas& atlas, int patch, int element_u,
                                  int element_v) const;

  Point at(const bsi::Atlas& atlas, const Place& place) const;

  // Returns the control points (m, by particle) of the surface that passes through an image of
  // points (m, by particle), on long open axes to order 4 (SplineAxis::passes_through_image()). The
  // control points of a border depend only on the image's points of
  // the same border, so that patches which share the border agree.
  std::vector<Vec3> interpolate(const bsi::Atlas& atlas, std::span<const Vec3> image) const;

  // Returns the map from control points to the points of the surface at `places`.
  SurfaceMap map_to(const bsi::Atlas& atlas, std::span<const Place> places) const;
  // Returns the places on the surface, by particle, at which the surface of interpolate() passes
  // through the image's points, or by them. If a particle belongs to several patches, its place is
  // in the first of them.
  std::vector<Place> image_places(const bsi::Atlas& atlas) const;

 private:
  int degree_;
  std::vector<Patch> patches_;
};

}  // namespace weft::sim
