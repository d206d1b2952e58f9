#include "sim/scene/shell_body.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/case/case_error.h"
#include "sim/scene/patch_joints.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

namespace {

// Points of the sampled surface per element and axis.
constexpr int samples_per_element = 2;

void require_control_points(const SceneBody& body, const BodyCase& from) {
  const int degree = body.material->spline_degree;
  const int least = SplineAxis::least_control_points(degree);
  for (const bsi::Patch& patch : body.atlas.patches()) {
    if (patch.rows >= least && patch.cols >= least) continue;
    throw CaseError(from.shape.location,
                    "the image of \"" + body.name + "\" has " + std::to_string(patch.rows) + " x " +
                        std::to_string(patch.cols) + " control points",
                    "expected at least " + std::to_string(least) + " x " + std::to_string(least) +
                        " with spline_degree = " + std::to_string(degree));
  }
}

// The parameters of the samples along an axis.
std::vector<double> sample_parameters(const SplineAxis& axis, bool is_closed) {
  std::vector<double> parameters;
  const int count = samples_per_element * axis.elements() + (is_closed ? 0 : 1);
  for (int i = 0; i < count; ++i)
    parameters.push_back(static_cast<double>(i) / samples_per_element);
  return parameters;
}

// Numbers the samples of all patches. Samples at the same point of a seam are the same sums of
// particles, up to rounding: they are one point.
class SeamPoints {
 public:
  int number_of(std::span<const SurfaceMap::Share> shares) {
    std::vector<std::pair<int, long long>> key;
    for (const auto& [particle, weight] : shares)
      key.emplace_back(particle, std::llround(1e9 * weight));
    std::sort(key.begin(), key.end());
    return numbers_.try_emplace(std::move(key), std::ssize(numbers_)).first->second;
  }

 private:
  std::map<std::vector<std::pair<int, long long>>, int> numbers_;
};

// Largest distance (m) of a surface from the triangles between its samples: h^2 / 8 times the
// largest second derivative, along either axis and across, as that of bilinear interpolation. The
// second derivatives of a spline lie between those at its knots and ends, here taken at the
// samples.
double largest_deviation(const SceneBody& body) {
  double largest = 0;
  const double spacing = 1.0 / samples_per_element;
  for (std::size_t p = 0; p < body.spline->patches().size(); ++p) {
    const auto& [u, v] = body.spline->patches()[p];
    const bsi::Patch& patch = body.atlas.patches()[p];
    for (const double at_v : sample_parameters(v, patch.wrap_v)) {
      for (const double at_u : sample_parameters(u, patch.wrap_u)) {
        const SplineBasis bu = u.at(at_u), bv = v.at(at_v);
        const std::vector<int> control =
            body.spline->control_points(body.atlas, static_cast<int>(p), bu.element, bv.element);
        Vec3 uu = Vec3::Zero(), vv = Vec3::Zero(), uv = Vec3::Zero();
        for (int j = 0, node = 0; j <= u.degree(); ++j) {
          for (int i = 0; i <= u.degree(); ++i, ++node) {
            const Vec3& x = body.rest[control[node]];
            uu += bu.second[i] * bv.value[j] * x;
            uv += bu.slope[i] * bv.slope[j] * x;
            vv += bu.value[i] * bv.second[j] * x;
          }
        }
        largest = std::max(largest, uu.norm() + 2 * uv.norm() + vv.norm());
      }
    }
  }
  return spacing * spacing / 8 * largest;
}

// Gauss points per element and axis by which masses are integrated.
constexpr int mass_points = 4;

// Area (m^2) per area of the parameters at a point of the rest surface; 0 where the tangents are
// parallel up to rounding.
double area_factor(const SceneBody& body, const SplineSurface::Point& point) {
  const Vec3 tangent_u = point.tangent_u(body.rest), tangent_v = point.tangent_v(body.rest);
  const double area = tangent_u.cross(tangent_v).norm();
  return area > 1e-10 * (tangent_u.squaredNorm() + tangent_v.squaredNorm()) ? area : 0;
}

}  // namespace

void make_spline(SceneBody& body, const BodyCase& from) {
  require_control_points(body, from);
  try {
    find_patch_joints(body.atlas);
  } catch (const std::invalid_argument& error) {
    throw CaseError(from.shape.location,
                    "the patches of \"" + body.name + "\" do not meet: " + error.what(),
                    "expected patches that share whole borders, with the same control points");
  }
  body.spline = std::make_shared<const SplineSurface>(body.atlas, body.material->spline_degree);
}

std::vector<Vec3> control_points_of(const SceneBody& body, const BodyCase& from,
                                    std::span<const Vec3> image) {
  if (from.control_net) return {image.begin(), image.end()};
  return body.spline->interpolate(body.atlas, image);
}

void visit_shell_mass(const SceneBody& body, const MassVisit& visit) {
  const double density = body.material->area_density();
  for (std::size_t p = 0; p < body.spline->patches().size(); ++p) {
    const auto& [u, v] = body.spline->patches()[p];
    const std::vector<QuadraturePoint> along_u = u.gauss_points(mass_points),
                                       along_v = v.gauss_points(mass_points);
    for (int element = 0; element < u.elements() * v.elements(); ++element) {
      const int first_u = mass_points * (element % u.elements());
      const int first_v = mass_points * (element / u.elements());
      for (int i = 0; i < mass_points * mass_points; ++i) {
        const QuadraturePoint& at_u = along_u[first_u + i % mass_points];
        const QuadraturePoint& at_v = along_v[first_v + i / mass_points];
        const SplineSurface::Place place{static_cast<int>(p), at_u.parameter, at_v.parameter};
        const SplineSurface::Point point = body.spline->at(body.atlas, place);
        visit(place, point, density * at_u.weight * at_v.weight * area_factor(body, point));
      }
    }
  }
}

std::vector<double> shell_masses(const SceneBody& body, const BodyCase& from) {
  std::vector<double> sums(body.particle_count(), 0.0);
  visit_shell_mass(
      body, [&](const SplineSurface::Place& place, const SplineSurface::Point& point, double mass) {
        if (!(mass > 0)) {
          throw CaseError(from.shape.location,
                          "the rest surface of \"" + body.name + "\" has no area in patch " +
                              std::to_string(place.patch) + ", near row " +
                              std::to_string(static_cast<int>(place.v)) + ", column " +
                              std::to_string(static_cast<int>(place.u)));
        }
        for (std::size_t i = 0; i < point.value.size(); ++i)
          sums[point.control_points[i]] += mass * point.value[i];
      });
  return sums;
}

void sample_shell(SceneBody& body) {
  std::vector<bsi::Patch> patches;
  std::vector<SplineSurface::Place> places;
  for (std::size_t p = 0; p < body.spline->patches().size(); ++p) {
    const auto& [u, v] = body.spline->patches()[p];
    bsi::Patch patch = body.atlas.patches()[p];
    const std::vector<double> along_u = sample_parameters(u, patch.wrap_u);
    const std::vector<double> along_v = sample_parameters(v, patch.wrap_v);
    patch.rows = static_cast<int>(along_v.size());
    patch.cols = static_cast<int>(along_u.size());
    patches.push_back(patch);
    for (const double at_v : along_v) {
      for (const double at_u : along_u) places.push_back({static_cast<int>(p), at_u, at_v});
    }
  }
  const SurfaceMap of_texels = body.spline->map_to(body.atlas, places);
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
  body.sampled.emplace(bsi::Atlas(std::move(patches), std::move(point_of_texel)),
                       SurfaceMap(std::move(first_share), std::move(shares)), body.rest);
  body.thickness += 2 * largest_deviation(body);
}

std::vector<BesideBorder> rows_beside_borders(const SceneBody& body, std::span<const int> held) {
  std::vector<BesideBorder> all;
  const auto is_held = [&](int particle) { return std::ranges::binary_search(held, particle); };
  for (std::size_t p = 0; p < body.atlas.patches().size(); ++p) {
    const bsi::Patch& patch = body.atlas.patches()[p];
    // Calls particle(line, i) for the control points i of a line of the image.
    const auto add_beside = [&](int border, int next, int count, const auto& particle) {
      for (int i = 0; i < count; ++i) {
        if (!is_held(particle(border, i))) return;
      }
      for (int i = 0; i < count; ++i) all.push_back({particle(next, i), particle(border, i)});
    };
    const auto in_row = [&](int row, int col) {
      return body.atlas.particle(static_cast<int>(p), row, col);
    };
    const auto in_column = [&](int col, int row) { return in_row(row, col); };
    if (!patch.wrap_v) {
      add_beside(0, 1, patch.cols, in_row);
      add_beside(patch.rows - 1, patch.rows - 2, patch.cols, in_row);
    }
    if (!patch.wrap_u) {
      add_beside(0, 1, patch.rows, in_column);
      add_beside(patch.cols - 1, patch.cols - 2, patch.rows, in_column);
    }
  }
  return all;
}

std::vector<int> with_clamped_rows(const SceneBody& body, const PinCase& pin,
                                   std::vector<int> held) {
  const std::vector<BesideBorder> added = rows_beside_borders(body, held);
  if (added.empty()) {
    throw CaseError(pin.location, "this clamp holds no edge of the shell",
                    "expected a pin that holds a whole border of a patch");
  }
  for (const BesideBorder& each : added) held.push_back(each.particle);
  std::ranges::sort(held);
  const auto repeated = std::ranges::unique(held);
  held.erase(repeated.begin(), repeated.end());
  return held;
}

}  // namespace weft::sim
