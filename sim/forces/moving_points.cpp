#include "sim/forces/moving_points.h"

#include <algorithm>

namespace weft::sim {

int MovingPoints::add(const PrescribedMotion* held, const Vec3& start) {
  int motion = -1;
  if (held != nullptr) {
    const auto found = std::ranges::find(motions_, held);
    motion = static_cast<int>(found - motions_.begin());
    if (found == motions_.end()) motions_.push_back(held);
  }
  motion_of_.push_back(motion);
  start_.push_back(start);
  position_.push_back(held != nullptr ? held->motion.pose(0).place(start) : start);
  velocity_.push_back(Vec3::Zero());
  return static_cast<int>(start_.size()) - 1;
}

int MovingPoints::add_on_body(const Scene& scene, const SceneBody& body, const Vec3& place) {
  const auto found = std::ranges::find_if(scene.prescribed, [&](const PrescribedMotion& held) {
    return held.moves && !held.particles.empty() &&
           &scene.body_of_particle(held.particles.front()) == &body;
  });
  if (found == scene.prescribed.end()) return add(nullptr, place);
  return add(&*found, found->motion.pose(0).start_of(place));
}

void MovingPoints::set_time(const Instant& now) {
  std::vector<RigidPose> poses;
  for (const PrescribedMotion* held : motions_)
    poses.push_back(held->motion.pose(now.time, now.within < now.time));
  for (std::size_t i = 0; i < start_.size(); ++i) {
    if (motion_of_[i] >= 0) poses[motion_of_[i]].place(start_[i], position_[i], velocity_[i]);
  }
}

}  // namespace weft::sim
