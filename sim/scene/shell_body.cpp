#include "sim/scene/shell_body.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/case/case_error.h"
#include "sim/scene/patch_joints.h"
#include "sim/scene/spline_sampling.h"

namespace weft::sim {

namespace {

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

// Number of Gauss points per element along each axis, for masses.
constexpr int mass_points = 4;

// Returns the area (m^2) per parameter area at a point of the rest surface. The result is 0 if the
// tangents are parallel up to rounding.
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
  SplineSampling sampling(body.atlas, *body.spline);
  body.sampled.emplace(std::move(sampling.atlas), std::move(sampling.map), body.rest);
  body.thickness += 2 * deviation_from_samples(body.atlas, *body.spline, body.rest);
}

std::vector<BesideBorder> rows_beside_borders(const SceneBody& body, std::span<const int> held) {
  std::vector<BesideBorder> all;
  const auto is_held = [&](int particle) { return std::ranges::binary_search(held, particle); };
  for (std::size_t p = 0; p < body.atlas.patches().size(); ++p) {
    const bsi::Patch& patch = body.atlas.patches()[p];
    // Adds the control points of row or column `next` if all control points of row or column
    // `border` are held. particle(line, i) returns control point i of row or column `line`, where 0
    // <= i < count.
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
