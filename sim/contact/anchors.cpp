#include "sim/contact/anchors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "sim/base/state_archive.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

// Returns the changes of the barycentric weights of a point that moves by `way` (m) in the plane of
// a triangle. The part of `way` across the plane does not count. All are 0 for a triangle without
// an area.
std::array<double, 3> weight_changes(const std::array<Vec3, 3>& x, const Vec3& way) {
  const Vec3 across = (x[1] - x[0]).cross(x[2] - x[0]);
  const double square = across.squaredNorm();
  if (!(square > 0)) return {0, 0, 0};
  const double one = across.cross(x[0] - x[2]).dot(way) / square;
  const double two = across.cross(x[1] - x[0]).dot(way) / square;
  return {-one - two, one, two};
}

}  // namespace

const Anchor* find_anchor(const Anchors& anchors, const AnchorKey& key) {
  const auto found = std::ranges::lower_bound(anchors, key, {}, &Anchor::key);
  return found == anchors.end() || found->key != key ? nullptr : &*found;
}

Anchor advanced_anchor(const AnchorKey& key, const Anchor* before, const Vec3& offset,
                       const Footing& foot, double distance) {
  Vec3 stretch = Vec3::Zero();
  if (before != nullptr) {
    stretch = offset - offset.dot(foot.normal) * foot.normal;
    const double length = stretch.norm();
    if (!(length > distance)) return *before;
    stretch *= distance / length;
  }
  Anchor anchor{key, foot.corners, foot.weights};
  const std::array<double, 3> changes = weight_changes(foot.x, -stretch);
  for (int k = 0; k < 3; ++k) anchor.weights[k] += changes[k];
  return anchor;
}

void transfer(StateArchive& archive, Anchors& anchors, const Scene& scene) {
  archive(anchors);
  const auto has_point = [&](int case_body, int point) {
    return case_body >= 0 && case_body < std::ssize(scene.case_order) && point >= 0 &&
           point < scene.bodies[scene.case_order[case_body]].point_count();
  };
  const bool fits = std::ranges::all_of(anchors, [&](const Anchor& anchor) {
    return has_point(anchor.key.body, anchor.key.point) &&
           std::ranges::all_of(anchor.corners,
                               [&](int corner) { return has_point(anchor.key.surface, corner); });
  });
  if (!fits || !std::ranges::is_sorted(anchors, {}, &Anchor::key))
    throw std::invalid_argument("a saved state with anchors of another scene");
}

}  // namespace weft::sim
