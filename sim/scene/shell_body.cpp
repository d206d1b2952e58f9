#include "sim/scene/shell_body.h"

#include <algorithm>
#include <cmath>
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

// Returns the vector area (m^2) per parameter area at a point of the rest surface. The result is 0
// if the tangents are parallel up to rounding.
Vec3 area_vector(const SceneBody& body, const SplineSurface::Point& point) {
  const Vec3 tangent_u = point.tangent_u(body.rest), tangent_v = point.tangent_v(body.rest);
  const Vec3 area = tangent_u.cross(tangent_v);
  const double least = 1e-10 * (tangent_u.squaredNorm() + tangent_v.squaredNorm());
  return area.norm() > least ? area : Vec3::Zero();
}

// Returns the index of the image's point nearest to a parameter of an axis.
int nearest_image_point(const SplineAxis& axis, double parameter) {
  int nearest = 0;
  for (int i = 1; i < axis.control_points(); ++i) {
    if (std::abs(axis.image_parameter(i) - parameter) <
        std::abs(axis.image_parameter(nearest) - parameter))
      nearest = i;
  }
  return nearest;
}

[[noreturn]] void refuse_rest(const SceneBody& body, const BodyCase& from,
                              const SplineSurface::Place& place) {
  const auto& [u, v] = body.spline->patches()[place.patch];
  std::string where = " near row " + std::to_string(nearest_image_point(v, place.v)) + ", column " +
                      std::to_string(nearest_image_point(u, place.u)) + " of the image";
  if (body.spline->patches().size() > 1) where += " of patch " + std::to_string(place.patch);
  throw CaseError(
      from.shape.location,
      "the rest surface of \"" + body.name + "\" has no area or folds back on itself" + where,
      "expected points that do not coincide, and a surface that turns by less than 90 "
      "degrees from each point of the image to the next");
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
        visit(place, point, density * at_u.weight * at_v.weight * area_vector(body, point).norm());
      }
    }
  }
}

SurfaceMap map_to_image(const SceneBody& body) {
  if (!body.spline) return {};
  return body.spline->map_to(body.atlas, body.spline->image_places(body.atlas));
}

Vec3 mean_of_image_points(const SceneBody& body, std::span<const Vec3> position,
                          std::span<const int> points) {
  std::vector<Vec3> room;
  const auto image = map_to_image(body).points_of(position, body.particle_count(), room);
  Vec3 sum = Vec3::Zero();
  for (const int point : points) sum += image[point];
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

void require_regular_rest(const SceneBody& body, const BodyCase& from) {
  for (int p = 0; p < std::ssize(body.spline->patches()); ++p) {
    const auto& [u, v] = body.spline->patches()[p];
    std::vector<QuadraturePoint> along_u = u.gauss_points(mass_points),
                                 along_v = v.gauss_points(mass_points);
    std::ranges::sort(along_u, {}, &QuadraturePoint::parameter);
    std::ranges::sort(along_v, {}, &QuadraturePoint::parameter);
    // The vector areas at the points of the row before and, so far, of this row.
    std::vector<Vec3> before, now;
    for (const QuadraturePoint& at_v : along_v) {
      now.clear();
      for (std::size_t i = 0; i < along_u.size(); ++i) {
        const SplineSurface::Place place{p, along_u[i].parameter, at_v.parameter};
        const Vec3 area = area_vector(body, body.spline->at(body.atlas, place));
        const bool turns =
            (i > 0 && area.dot(now.back()) <= 0) || (!before.empty() && area.dot(before[i]) <= 0);
        if (turns || area.isZero(0)) refuse_rest(body, from, place);
        now.push_back(area);
      }
      before.swap(now);
    }
  }
}

std::vector<double> shell_masses(const SceneBody& body) {
  std::vector<double> sums(body.particle_count(), 0.0);
  visit_shell_mass(
      body, [&](const SplineSurface::Place&, const SplineSurface::Point& point, double mass) {
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
