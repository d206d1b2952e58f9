// The triangles that represent a spline surface in contact, in pictures and in the check for
// intersections (docs/theory.md, section 12).
#pragma once

#include <span>
#include <vector>

#include "sim/scene/spline_surface.h"
#include "sim/scene/surface_map.h"

namespace weft::sim {

// Samples of a surface at the ends and in the middle of its elements along each axis, as an image.
// Samples at the same point of a seam are one point.
struct SplineSampling {
  SplineSampling(const bsi::Atlas& control_points, const SplineSurface& surface);

  bsi::Atlas atlas;  // of the samples
  SurfaceMap map;    // from control points, by particle, to samples
};

// Returns an upper bound (m) of the distance of a surface with these control points from the
// triangles between its samples. The bound is s^2 / 8 times the largest |x_uu| + 2 |x_uv| + |x_vv|,
// the error of linear interpolation, where s is the distance of two samples in the parameter.
// Second derivatives of splines are splines themselves and lie within the hull of their control
// points. O(control points).
double deviation_from_samples(const bsi::Atlas& atlas, const SplineSurface& surface,
                              std::span<const Eigen::Vector3d> control_points);

}  // namespace weft::sim
