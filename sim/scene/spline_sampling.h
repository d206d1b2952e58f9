// Triangles that represent a spline surface, for example in contact (docs/theory.md, section 12).
#pragma once

#include <span>
#include <vector>

#include "sim/scene/spline_surface.h"
#include "sim/scene/surface_map.h"

namespace weft::sim {

// Samples of a spline surface, as an image. Along each axis, they lie at the ends and in the middle
// of the elements. Samples at the same point of a seam are one point.
struct SplineSampling {
  static constexpr int per_element = 2;  // number of samples per element along each axis

  SplineSampling(const bsi::Atlas& control_points, const SplineSurface& surface);

  bsi::Atlas atlas;  // image of the samples
  SurfaceMap map;    // from control points (particles) to samples
};

// Returns an upper bound (m) of the distance between the spline surface with these control points
// and the triangles between its samples. The bound is the error of linear interpolation: s^2 / 8
// times the largest |x_uu| + 2 |x_uv| + |x_vv|. s is the distance of neighbouring samples in the
// parameter. Second derivatives of splines are splines, too, and lie within the hull of their
// control points. O(control points).
double deviation_from_samples(const bsi::Atlas& atlas, const SplineSurface& surface,
                              std::span<const Eigen::Vector3d> control_points);

// Raises by_sample[i] (m) to the bound of deviation_from_samples() over the elements around sample
// i, where it is lower. `samples` is the atlas of SplineSampling. The surface over a triangle is
// therefore no farther from it than the largest entry of its three corners. O(control points).
void raise_to_deviations(const bsi::Atlas& atlas, const SplineSurface& surface,
                         const bsi::Atlas& samples, std::span<const Eigen::Vector3d> control_points,
                         std::span<double> by_sample);

}  // namespace weft::sim
