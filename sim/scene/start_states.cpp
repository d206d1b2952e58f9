#include "sim/scene/start_states.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

namespace {

// A place between two texels of an axis.
struct AxisPlace {
  int low = 0, high = 0;
  double share = 0;  // weight of `high`
};

// Returns the place of texel `i` of `count` on an axis of `from` texels.
AxisPlace place_on_axis(int i, int count, int from, bool closed) {
  const double at = closed ? static_cast<double>(i) * from / count
                           : static_cast<double>(i) * (from - 1) / (count - 1);
  const int low = std::min(static_cast<int>(std::floor(at)), from - 1);
  return {low, closed ? (low + 1) % from : std::min(low + 1, from - 1), at - low};
}

// Returns the parameter, on the axis `from`, of the point that divides it as the point with the
// parameter `at` divides the axis `to`.
double parameter_on(const SplineAxis& from, const SplineAxis& to, double at) {
  const double part = (at - to.image_parameter(0)) / to.elements();
  const double found = from.image_parameter(0) + part * from.elements();
  return std::clamp(found, 0.0, static_cast<double>(from.elements()));
}

bool has_enough_points(const bsi::Atlas& atlas, int degree) {
  return std::ranges::all_of(atlas.patches(), [&](const bsi::Patch& patch) {
    return std::min(patch.rows, patch.cols) >= SplineAxis::least_control_points(degree);
  });
}

bool have_equal_sizes(const bsi::Atlas& one, const bsi::Atlas& other) {
  return std::ranges::equal(one.patches(), other.patches(),
                            [](const bsi::Patch& a, const bsi::Patch& b) {
                              return a.rows == b.rows && a.cols == b.cols;
                            });
}

Vec3 blend(const Vec3& a, const Vec3& b, double share) {
  return share == 0 ? a : Vec3((1 - share) * a + share * b);
}

}  // namespace

const BodyState* StartStates::find(const std::string& name) const {
  const auto found = std::ranges::find(bodies, name, &BodyState::name);
  return found == bodies.end() ? nullptr : &*found;
}

std::vector<Vec3> resampled(const std::vector<Vec3>& values, const bsi::Atlas& from,
                            const bsi::Atlas& to) {
  std::vector<Vec3> result(to.particle_count());
  for (int p = 0; p < static_cast<int>(to.patches().size()); ++p) {
    const bsi::Patch &source = from.patches()[p], &target = to.patches()[p];
    const auto at = [&](int row, int col) -> const Vec3& {
      return values[from.first_texel(p) + row * source.cols + col];
    };
    for (int row = 0; row < target.rows; ++row) {
      const AxisPlace v = place_on_axis(row, target.rows, source.rows, target.wrap_v);
      for (int col = 0; col < target.cols; ++col) {
        const AxisPlace u = place_on_axis(col, target.cols, source.cols, target.wrap_u);
        const int texel = to.first_texel(p) + row * target.cols + col;
        result[to.particle_of_texel(texel)] =
            blend(blend(at(v.low, u.low), at(v.low, u.high), u.share),
                  blend(at(v.high, u.low), at(v.high, u.high), u.share), v.share);
      }
    }
  }
  return result;
}

std::vector<Vec3> resampled(const std::vector<Vec3>& values, const bsi::Atlas& from,
                            const bsi::Atlas& to, const SplineSurface& surface) {
  if (have_equal_sizes(from, to) || !has_enough_points(from, surface.degree()))
    return resampled(values, from, to);
  std::vector<Vec3> image(from.particle_count());
  for (std::size_t texel = 0; texel < values.size(); ++texel)
    image[from.particle_of_texel(static_cast<int>(texel))] = values[texel];
  const SplineSurface source(from, surface.degree());
  const std::vector<Vec3> control_points = source.interpolate(from, image);
  std::vector<Vec3> result;
  for (const SplineSurface::Place& place : surface.image_places(to)) {
    const auto& [u_from, v_from] = source.patches()[place.patch];
    const auto& [u_to, v_to] = surface.patches()[place.patch];
    const SplineSurface::Place there{place.patch, parameter_on(u_from, u_to, place.u),
                                     parameter_on(v_from, v_to, place.v)};
    result.push_back(source.at(from, there).position(control_points));
  }
  return result;
}

}  // namespace weft::sim
