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

}  // namespace weft::sim
