#include "sim/scene/load_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "sim/case/case_error.h"
#include "sim/scene/pins.h"

namespace weft::sim {

namespace {

// Gauss points on [0, 1] of the rule with two points, whose weights are both 1/2.
constexpr std::array<double, 2> gauss{0.21132486540518712, 0.78867513459481288};

// The surface of cloth, bilinear in each cell of the image.
class CellSurface {
 public:
  explicit CellSurface(const SceneBody& body) : atlas_(body.atlas) {}

  int cells_u(int patch) const { return atlas_.patches()[patch].quad_cols(); }
  int cells_v(int patch) const { return atlas_.patches()[patch].quad_rows(); }
  SplineSurface::Point at(const SplineSurface::Place& place) const {
    const int col = std::min(static_cast<int>(place.u), cells_u(place.patch) - 1);
    const int row = std::min(static_cast<int>(place.v), cells_v(place.patch) - 1);
    const double u = place.u - col, v = place.v - row;
    SplineSurface::Point point;
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        point.control_points.push_back(atlas_.particle(place.patch, row + j, col + i));
        const double along = i == 0 ? 1 - u : u, across = j == 0 ? 1 - v : v;
        point.value.push_back(along * across);
        point.slope_u.push_back((i == 0 ? -1 : 1) * across);
        point.slope_v.push_back((j == 0 ? -1 : 1) * along);
      }
    }
    return point;
  }
  SplineSurface::Place vertex(int particle) const {
    const bsi::TexelAddress place = atlas_.particle_address(particle);
    return {place.patch, static_cast<double>(place.col), static_cast<double>(place.row)};
  }

 private:
  const bsi::Atlas& atlas_;
};

class ShellSurface {
 public:
  explicit ShellSurface(const SceneBody& body)
      : atlas_(body.atlas), spline_(*body.spline), places_(spline_.image_places(body.atlas)) {}

  int cells_u(int patch) const { return spline_.patches()[patch].u.elements(); }
  int cells_v(int patch) const { return spline_.patches()[patch].v.elements(); }
  SplineSurface::Point at(const SplineSurface::Place& place) const {
    return spline_.at(atlas_, place);
  }
  SplineSurface::Place vertex(int particle) const { return places_[particle]; }

 private:
  const bsi::Atlas& atlas_;
  const SplineSurface& spline_;
  std::vector<SplineSurface::Place> places_;
};

void negate(std::vector<double>& values) {
  for (double& each : values) each = -each;
}

template <class Surface>
class Finder {
 public:
  Finder(const SceneBody& body, const LoadCase& load, std::span<const Vec3> positions)
      : body_(body), load_(load), positions_(positions), surface_(body) {
    const VertexSelection& of = load.vertices;
    if (of.region_min && of.region_max)
      box_ = selecting_box(*of.region_min, *of.region_max, positions);
  }

  std::vector<LoadPoint> find() {
    switch (load_.type) {
      case LoadType::point:
        add_vertices();
        break;
      case LoadType::line:
      case LoadType::moment:
        for (const std::string& edge : load_.vertices.edges) add_edge(edge);
        break;
      case LoadType::area:
      case LoadType::pressure:
        add_area();
        break;
    }
    if (points_.empty())
      throw CaseError(load_.location, "the load selects nothing of \"" + body_.name + '"');
    return std::move(points_);
  }

 private:
  void add_vertices() {
    for (const int i : select_vertices(load_.vertices, load_.location, "load", body_, positions_))
      points_.push_back({.at = surface_.at(surface_.vertex(i))});
  }

  // Adds two points for each segment of an edge. The parameters are swapped or reversed so that v
  // runs into the surface and the normal keeps its direction.
  void add_edge(const std::string& edge) {
    VertexSelection only;
    only.edges = {edge};
    only.patch = load_.vertices.patch;
    // Throws CaseError if the surface has no such edge.
    select_vertices(only, load_.location, "load", body_, positions_);
    const int patch = only.patch;
    const bool is_row = edge == "first_row" || edge == "last_row";
    const bool is_first = edge == "first_row" || edge == "first_col";
    const int cells = is_row ? surface_.cells_u(patch) : surface_.cells_v(patch);
    const double across = is_first ? 0 : is_row ? surface_.cells_v(patch) : surface_.cells_u(patch);
    for (int cell = 0; cell < cells; ++cell) {
      for (const double inner : gauss) {
        const double along = cell + inner;
        LoadPoint point{.at = surface_.at(is_row ? SplineSurface::Place{patch, along, across}
                                                 : SplineSurface::Place{patch, across, along})};
        if (!is_row) std::swap(point.at.slope_u, point.at.slope_v);
        if (is_row != is_first) negate(point.at.slope_u);
        if (!is_first) negate(point.at.slope_v);
        point.measure = 0.5 * point.at.tangent_u(body_.rest).norm();
        points_.push_back(std::move(point));
      }
    }
  }

  void add_area() {
    for (int patch = 0; patch < static_cast<int>(body_.atlas.patches().size()); ++patch) {
      for (int row = 0; row < surface_.cells_v(patch); ++row) {
        for (int col = 0; col < surface_.cells_u(patch); ++col) add_cell(patch, row, col);
      }
    }
  }
  void add_cell(int patch, int row, int col) {
    for (const double v : gauss) {
      for (const double u : gauss) {
        LoadPoint point{.at = surface_.at({patch, col + u, row + v})};
        if (box_ && !box_->contains(point.at.position(positions_))) continue;
        point.area_factor =
            point.at.tangent_u(body_.rest).cross(point.at.tangent_v(body_.rest)).norm();
        point.measure = point.area_factor / 4;
        points_.push_back(std::move(point));
      }
    }
  }

  const SceneBody& body_;
  const LoadCase& load_;
  std::span<const Vec3> positions_;
  Surface surface_;
  std::optional<Eigen::AlignedBox3d> box_;
  std::vector<LoadPoint> points_;
};

}  // namespace

int nodes_per_load_point(const SceneBody& body) {
  return body.spline ? body.spline->nodes_per_element() : 4;
}

std::vector<LoadPoint> find_load_points(const SceneBody& body, const LoadCase& load,
                                        std::span<const Vec3> positions) {
  if (body.spline) return Finder<ShellSurface>(body, load, positions).find();
  return Finder<CellSurface>(body, load, positions).find();
}

}  // namespace weft::sim
