#include "sim/simulation/moving_boxes.h"

#include <algorithm>

namespace weft::sim {

MovingBoxes::MovingBoxes(const Scene& scene) : range_(scene.source.contact.range) {
  if (!scene.source.contact.enabled) return;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (!held.moves || held.particles.empty()) continue;
    const SceneBody& body = scene.body_of_particle(held.particles.front());
    if (body.dynamic) continue;
    Eigen::AlignedBox3d box;
    for (const Vec3& point : held.start) box.extend(point);
    moving_.push_back({&held, box.center(), 0.5 * box.sizes(), body.thickness});
  }
}

bool MovingBoxes::may_reach(const Eigen::AlignedBox3d& box, double thickness, double from,
                            double to) const {
  return std::ranges::any_of(moving_, [&](const Moving& moving) {
    const double travel = moving.held->motion.bounds(from, to, moving.held->radius).travel;
    if (travel == 0) return false;
    const RigidPose pose = moving.held->motion.pose(from);
    const Vec3 reach = pose.rotation.cwiseAbs() * moving.half_extents +
                       Vec3::Constant(travel + range_ + 0.5 * (thickness + moving.thickness));
    const Vec3 centre = pose.place(moving.centre);
    return box.intersects({centre - reach, centre + reach});
  });
}

}  // namespace weft::sim
