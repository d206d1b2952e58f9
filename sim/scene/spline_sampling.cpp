#include "sim/scene/spline_sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace weft::sim {

namespace {

using Vec3 = Eigen::Vector3d;

constexpr int samples_per_element = SplineSampling::per_element;

// Returns the parameters of the samples along an axis.
std::vector<double> sample_parameters(const SplineAxis& axis, bool is_closed) {
  std::vector<double> parameters;
  const int count = samples_per_element * axis.elements() + (is_closed ? 0 : 1);
  for (int i = 0; i < count; ++i)
    parameters.push_back(static_cast<double>(i) / samples_per_element);
  return parameters;
}

// Numbers the samples of all patches. Samples at the same point of a seam have the same weights up
// to rounding, and get the same number.
class SeamPoints {
 public:
  int number_of(std::span<const SurfaceMap::Share> shares) {
    std::vector<std::pair<int, long long>> key;
    for (const auto& [particle, weight] : shares)
      key.emplace_back(particle, std::llround(1e9 * weight));
    return numbers_.try_emplace(std::move(key), std::ssize(numbers_)).first->second;
  }

 private:
  std::map<std::vector<std::pair<int, long long>>, int> numbers_;
};

// The places of all samples, and the patches of their image.
struct Samples {
  std::vector<bsi::Patch> patches;
  std::vector<SplineSurface::Place> places;
};

Samples samples_of(const bsi::Atlas& control_points, const SplineSurface& surface) {
  Samples samples;
  for (std::size_t p = 0; p < surface.patches().size(); ++p) {
    const auto& [u, v] = surface.patches()[p];
    bsi::Patch patch = control_points.patches()[p];
    const std::vector<double> along_u = sample_parameters(u, patch.wrap_u);
    const std::vector<double> along_v = sample_parameters(v, patch.wrap_v);
    patch.rows = static_cast<int>(along_v.size());
    patch.cols = static_cast<int>(along_u.size());
    samples.patches.push_back(patch);
    for (const double at_v : along_v) {
      for (const double at_u : along_u) samples.places.push_back({static_cast<int>(p), at_u, at_v});
    }
  }
  return samples;
}

}  // namespace

SplineSampling::SplineSampling(const bsi::Atlas& control_points, const SplineSurface& surface) {
  Samples samples = samples_of(control_points, surface);
  const SurfaceMap of_texels = surface.map_to(control_points, samples.places);
  SeamPoints seams;
  std::vector<int> point_of_texel, first_share{0};
  std::vector<SurfaceMap::Share> shares;
  for (int texel = 0; texel < of_texels.point_count(); ++texel) {
    const std::span<const SurfaceMap::Share> own = of_texels.shares(texel);
    point_of_texel.push_back(seams.number_of(own));
    if (point_of_texel.back() + 1 < static_cast<int>(first_share.size())) continue;
    shares.insert(shares.end(), own.begin(), own.end());
    first_share.push_back(static_cast<int>(shares.size()));
  }
  if (first_share.size() == point_of_texel.size() + 1) point_of_texel.clear();
  atlas = bsi::Atlas(std::move(samples.patches), std::move(point_of_texel));
  map = SurfaceMap(std::move(first_share), std::move(shares));
}

namespace {

double square(double x) { return x * x; }

// Returns an upper bound of |x_uu| + 2 |x_uv| + |x_vv| (m) over an element. `x` has the control
// points of the element, row by row.
double largest_second_derivative(const SplineSurface::Patch& patch, int element_u, int element_v,
                                 std::span<const Vec3> x) {
  const int degree = patch.u.degree(), count = degree + 1;
  const SplineAxis::DifferenceFactors u = patch.u.difference_factors(element_u);
  const SplineAxis::DifferenceFactors v = patch.v.difference_factors(element_v);
  const auto slope_u = [&](int i, int j) {
    return Vec3(u.first[i] * (x[j * count + i + 1] - x[j * count + i]));
  };
  const auto slope_v = [&](int i, int j) {
    return Vec3(v.first[j] * (x[(j + 1) * count + i] - x[j * count + i]));
  };
  double uu = 0, uv = 0, vv = 0;
  for (int j = 0; j <= degree; ++j) {
    for (int i = 0; i <= degree; ++i) {
      if (i + 2 <= degree)
        uu = std::max(uu, square(u.second[i]) * (slope_u(i + 1, j) - slope_u(i, j)).squaredNorm());
      if (j + 2 <= degree)
        vv = std::max(vv, square(v.second[j]) * (slope_v(i, j + 1) - slope_v(i, j)).squaredNorm());
      if (i < degree && j < degree)
        uv = std::max(uv, square(v.first[j]) * (slope_u(i, j + 1) - slope_u(i, j)).squaredNorm());
    }
  }
  return std::sqrt(uu) + 2 * std::sqrt(uv) + std::sqrt(vv);
}

// Calls visit(patch, element_u, element_v, bound) for each element. `bound` (m) is an upper bound
// of the distance between the element and its triangles.
template <class Visit>
void visit_deviations(const bsi::Atlas& atlas, const SplineSurface& surface,
                      std::span<const Vec3> control_points, const Visit& visit) {
  constexpr double spacing = 1.0 / samples_per_element;
  constexpr int most = (highest_spline_degree + 1) * (highest_spline_degree + 1);
  std::array<Vec3, most> x;
  const int count = surface.degree() + 1;
  for (int p = 0; p < std::ssize(surface.patches()); ++p) {
    const SplineSurface::Patch& patch = surface.patches()[p];
    for (int ev = 0; ev < patch.v.elements(); ++ev) {
      for (int eu = 0; eu < patch.u.elements(); ++eu) {
        for (int i = 0; i < count * count; ++i) {
          const int row = patch.v.control_point(ev, i / count);
          const int col = patch.u.control_point(eu, i % count);
          x[i] = control_points[atlas.particle(p, row, col)];
        }
        visit(p, eu, ev, spacing * spacing / 8 * largest_second_derivative(patch, eu, ev, x));
      }
    }
  }
}

}  // namespace

double deviation_from_samples(const bsi::Atlas& atlas, const SplineSurface& surface,
                              std::span<const Vec3> control_points) {
  double largest = 0;
  visit_deviations(atlas, surface, control_points,
                   [&](int, int, int, double bound) { largest = std::max(largest, bound); });
  return largest;
}

void raise_to_deviations(const bsi::Atlas& atlas, const SplineSurface& surface,
                         const bsi::Atlas& samples, std::span<const Vec3> control_points,
                         std::span<double> by_sample) {
  visit_deviations(atlas, surface, control_points, [&](int p, int eu, int ev, double bound) {
    const bsi::Patch& patch = samples.patches()[p];
    for (int i = 0; i <= samples_per_element; ++i) {
      const int row = (samples_per_element * ev + i) % patch.rows;
      for (int j = 0; j <= samples_per_element; ++j) {
        const int col = (samples_per_element * eu + j) % patch.cols;
        double& largest = by_sample[samples.particle(p, row, col)];
        largest = std::max(largest, bound);
      }
    }
  });
}

}  // namespace weft::sim
