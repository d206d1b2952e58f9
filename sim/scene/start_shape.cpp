#include "sim/scene/start_shape.h"

#include <algorithm>
#include <cmath>

#include "sim/case/case_error.h"
#include "sim/scene/shape_builder.h"

namespace weft::sim {

namespace {

bool is_alike(const bsi::Atlas& a, const bsi::Atlas& b) {
  return std::ranges::equal(a.patches(), b.patches(),
                            [](const bsi::Patch& one, const bsi::Patch& other) {
                              return one.rows == other.rows && one.cols == other.cols &&
                                     one.wrap_u == other.wrap_u && one.wrap_v == other.wrap_v;
                            }) &&
         std::ranges::equal(a.texel_to_particle(), b.texel_to_particle());
}

}  // namespace

std::vector<Vec3> bend(const std::vector<Vec3>& points, double radius, double direction_deg) {
  const double angle = direction_deg * (std::acos(-1.0) / 180);
  const Vec3 along(std::cos(angle), std::sin(angle), 0);
  const auto [least, most] =
      std::ranges::minmax(points, {}, [&](const Vec3& point) { return point.dot(along); });
  const double middle = 0.5 * (least.dot(along) + most.dot(along));
  std::vector<Vec3> bent(points);
  for (Vec3& point : bent) {
    const double s = point.dot(along) - middle, z = point.z();
    point += ((radius - z) * std::sin(s / radius) - s) * along;
    // 1 - cos(s / R) is computed from the half angle to avoid cancellation in slight bends.
    const double half_sine = std::sin(0.5 * s / radius);
    point.z() = z + 2 * (radius - z) * half_sine * half_sine;
  }
  return bent;
}

std::vector<Vec3> start_shape(const BodyCase& from, const SceneBody& body, const Case& source) {
  if (!from.start) return body.rest;
  if (from.start->bend_radius)
    return bend(body.rest, *from.start->bend_radius, from.start->bend_direction_deg.value_or(0));
  const ShapeCase& shape = *from.start->shape;
  bsi::Surface surface = build_shape(shape, source);
  if (!is_alike(surface.atlas, body.atlas)) {
    throw CaseError(
        shape.location,
        "the image of this start is not like that of the rest shape of \"" + body.name + "\"",
        "expected as many rows, columns and patches, closed and sewn alike");
  }
  return std::move(surface.positions);
}

}  // namespace weft::sim
