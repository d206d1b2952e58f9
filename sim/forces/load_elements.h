// Forces and stiffness of loads on cells of cloth and elements of spline shells.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "materials/surface_load.h"
#include "sim/forces/force.h"
#include "sim/forces/stencil_array.h"
#include "sim/scene/load_points.h"

namespace weft::sim {

// The value of a load at a time. `force` (N, N/m or N/m^2) has components in the frame of the
// surface if the load is a follower. `scalar` is the value of a pressure (Pa) or of a moment (N
// m/m).
struct LoadValue {
  LoadType type = LoadType::point;
  bool follower = false;
  Vec3 force{0, 0, 0};
  double scalar = 0;

  bool turns() const { return follower || type == LoadType::pressure || type == LoadType::moment; }
};

// All load points that depend on `nodes` particles each: points on cells of cloth, or on elements
// of shells of one degree.
template <int nodes>
class LoadElements {
 public:
  using Stencil = std::array<int, nodes>;
  using Nodes = materials::NodesOf<double, nodes>;
  using Blocks = materials::StencilMatrix<double, nodes>;

  // Adds a point of a load. `load` is the index of the load in lists of LoadValue. Consecutive
  // points of one element share a stencil.
  void add(int load, int first_particle, const LoadPoint& from) {
    Stencil stencil;
    Point point{.load = load, .measure = from.measure, .parameters = from.measure};
    point.parameters /= from.area_factor;
    for (int i = 0; i < nodes; ++i) {
      stencil[i] = first_particle + from.at.control_points[i];
      point.value[i] = from.at.value[i];
      point.slope_u[i] = from.at.slope_u[i];
      point.slope_v[i] = from.at.slope_v[i];
    }
    if (stencils_.empty() || stencils_.back() != stencil) {
      stencils_.push_back(stencil);
      first_point_.push_back(static_cast<int>(points_.size()));
    }
    points_.push_back(point);
  }
  // Must be called once, after the last add().
  void finish(int particle_count) {
    first_point_.push_back(static_cast<int>(points_.size()));
    elements_ = StencilArray<nodes>(stencils_, particle_count);
  }
  bool is_empty() const { return stencils_.empty(); }

  void add_forces(std::span<const LoadValue> loads, std::span<const Vec3> position,
                  std::span<Vec3> force, int threads) const {
    elements_.for_each(threads, [&](int e) {
      const Nodes x = gather(e, position);
      Nodes sum = Nodes::Zero();
      for (int p = first_point_[e]; p < first_point_[e + 1]; ++p) {
        const Point& point = points_[p];
        const materials::SurfaceForce f = force_at(loads[point.load], point, tangents(point, x));
        for (int i = 0; i < nodes; ++i)
          sum.col(i) += point.value[i] * f.position + point.slope_u[i] * f.along_u +
                        point.slope_v[i] * f.along_v;
      }
      for (int i = 0; i < nodes; ++i) force[stencils_[e][i]] += sum.col(i);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const {
    elements_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) { elements_.attach(pattern); }

  // Adds the symmetric part of -dF/dx of the loads that turn with the surface.
  void add_stiffness(std::span<const LoadValue> loads, std::span<const Vec3> position,
                     BlockMatrix& matrix, int threads) const {
    elements_.for_each(threads, [&](int e) {
      const Nodes x = gather(e, position);
      Blocks sum;
      sum.blocks.fill(Mat3::Zero());
      bool turns = false;
      for (int p = first_point_[e]; p < first_point_[e + 1]; ++p) {
        if (!loads[points_[p].load].turns()) continue;
        turns = true;
        add_point_stiffness(loads[points_[p].load], points_[p], x, sum);
      }
      if (turns) elements_.add_blocks(e, sum, matrix);
    });
  }

 private:
  struct Point {
    int load = 0;
    double measure = 0;     // length (m) or area (m^2) at rest; 1 for a vertex
    double parameters = 0;  // area in parameter space, for pressures
    std::array<double, nodes> value{}, slope_u{}, slope_v{};
  };

  Nodes gather(int element, std::span<const Vec3> values) const {
    Nodes result;
    for (int i = 0; i < nodes; ++i) result.col(i) = values[stencils_[element][i]];
    return result;
  }
  static materials::Tangents tangents(const Point& point, const Nodes& x) {
    materials::Tangents result;
    for (int i = 0; i < nodes; ++i) {
      result.u += point.slope_u[i] * x.col(i);
      result.v += point.slope_v[i] * x.col(i);
    }
    return result;
  }
  static materials::SurfaceForce force_at(const LoadValue& load, const Point& point,
                                          const materials::Tangents& tangents) {
    if (load.type == LoadType::pressure)
      return materials::pressure_load(tangents, point.parameters * load.scalar);
    if (load.type == LoadType::moment)
      return materials::edge_moment(tangents, point.measure * load.scalar);
    if (load.follower) return materials::turning_load(tangents, point.measure * load.force);
    return {.position = point.measure * load.force};
  }
  static materials::SurfaceForceSlopes slopes_at(const LoadValue& load, const Point& point,
                                                 const materials::Tangents& tangents) {
    if (load.type == LoadType::pressure)
      return materials::pressure_load_slopes(tangents, point.parameters * load.scalar);
    if (load.type == LoadType::moment)
      return materials::edge_moment_slopes(tangents, point.measure * load.scalar);
    return materials::turning_load_slopes(tangents, point.measure * load.force);
  }

  static void add_point_stiffness(const LoadValue& load, const Point& point, const Nodes& x,
                                  Blocks& sum) {
    const materials::SurfaceForceSlopes slopes = slopes_at(load, point, tangents(point, x));
    // The derivative of the force on node a by the position of node b.
    const auto slope = [&](int a, int b) {
      Mat3 total = Mat3::Zero();
      const std::array<double, 3> factor{point.value[a], point.slope_u[a], point.slope_v[a]};
      for (int i = 0; i < 3; ++i)
        total +=
            factor[i] * (point.slope_u[b] * slopes.by_u[i] + point.slope_v[b] * slopes.by_v[i]);
      return total;
    };
    for (int a = 0; a < nodes; ++a) {
      for (int b = a; b < nodes; ++b) sum(a, b) -= 0.5 * (slope(a, b) + slope(b, a).transpose());
    }
  }

  std::vector<Stencil> stencils_;
  // Index of the first point, by element. The last entry is the count of all points.
  std::vector<int> first_point_;
  std::vector<Point> points_;
  StencilArray<nodes> elements_;
};

}  // namespace weft::sim
