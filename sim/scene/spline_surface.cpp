#include "sim/scene/spline_surface.h"

#include <map>

#include "sim/scene/spline_interpolation.h"

namespace weft::sim {

SplineSurface::SplineSurface(const bsi::Atlas& atlas, int degree) : degree_(degree) {
  for (const bsi::Patch& patch : atlas.patches()) {
    patches_.push_back({SplineAxis(degree, patch.cols, patch.wrap_u),
                        SplineAxis(degree, patch.rows, patch.wrap_v)});
  }
}

std::vector<int> SplineSurface::control_points(const bsi::Atlas& atlas, int patch, int element_u,
                                               int element_v) const {
  const auto& [u, v] = patches_[patch];
  std::vector<int> particles;
  for (int j = 0; j <= degree_; ++j) {
    for (int i = 0; i <= degree_; ++i) {
      particles.push_back(
          atlas.particle(patch, v.control_point(element_v, j), u.control_point(element_u, i)));
    }
  }
  return particles;
}

SplineSurface::Point SplineSurface::at(const bsi::Atlas& atlas, const Place& place) const {
  const SplineBasis u = patches_[place.patch].u.at(place.u);
  const SplineBasis v = patches_[place.patch].v.at(place.v);
  Point point{control_points(atlas, place.patch, u.element, v.element), {}, {}, {}};
  for (int j = 0; j <= degree_; ++j) {
    for (int i = 0; i <= degree_; ++i) {
      point.value.push_back(u.value[i] * v.value[j]);
      point.slope_u.push_back(u.slope[i] * v.value[j]);
      point.slope_v.push_back(u.value[i] * v.slope[j]);
    }
  }
  return point;
}

std::vector<Eigen::Vector3d> SplineSurface::interpolate(const bsi::Atlas& atlas,
                                                        std::span<const Vec3> image) const {
  std::vector<Vec3> control(image.size(), Vec3::Zero());
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const int patch = static_cast<int>(p);
    const auto& [u, v] = patches_[p];
    const int rows = v.control_points(), cols = u.control_points();
    // Rows of the image become columns, three for their coordinates, and then columns do.
    Eigen::MatrixXd by_row(cols, 3 * rows), by_col(rows, 3 * cols);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < cols; ++c)
        by_row.block<1, 3>(c, 3 * r) = image[atlas.particle(patch, r, c)].transpose();
    }
    by_row = control_points_of(u, by_row);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < cols; ++c) by_col.block<1, 3>(r, 3 * c) = by_row.block<1, 3>(c, 3 * r);
    }
    by_col = control_points_of(v, by_col);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < cols; ++c)
        control[atlas.particle(patch, r, c)] = by_col.block<1, 3>(r, 3 * c).transpose();
    }
  }
  return control;
}

SurfaceMap SplineSurface::map_to(const bsi::Atlas& atlas, std::span<const Place> places) const {
  std::vector<int> first_share{0};
  std::vector<SurfaceMap::Share> shares;
  for (const Place& place : places) {
    const Point point = at(atlas, place);
    // At a collapsed border, a particle may be several control points.
    std::map<int, double> weights;
    for (std::size_t i = 0; i < point.value.size(); ++i) {
      if (point.value[i] != 0) weights[point.control_points[i]] += point.value[i];
    }
    for (const auto& [particle, weight] : weights) shares.push_back({particle, weight});
    first_share.push_back(static_cast<int>(shares.size()));
  }
  return {std::move(first_share), std::move(shares)};
}

std::vector<SplineSurface::Place> SplineSurface::image_places(const bsi::Atlas& atlas) const {
  std::vector<Place> places(atlas.particle_count());
  for (std::size_t p = patches_.size(); p-- > 0;) {
    const int patch = static_cast<int>(p);
    const auto& [u, v] = patches_[p];
    for (int r = v.control_points() - 1; r >= 0; --r) {
      for (int c = u.control_points() - 1; c >= 0; --c)
        places[atlas.particle(patch, r, c)] = {patch, u.image_parameter(c), v.image_parameter(r)};
    }
  }
  return places;
}

}  // namespace weft::sim
