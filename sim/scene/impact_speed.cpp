#include "sim/scene/impact_speed.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/scene/sliding_supports.h"

namespace weft::sim {

namespace {

constexpr double least_impact_speed = 0.5;  // m/s

// Returns all values that decide how large a varying value becomes.
std::vector<Vec3> values_of(const Varying<Vec3>& varying) {
  if (varying.curve() != nullptr) return varying.curve()->values;
  if (varying.gust() == nullptr) return {varying.constant()};
  constexpr double deviations = 3;  // that hardly any gust exceeds
  return {(1 + deviations * varying.gust()->intensity) * varying.gust()->mean};
}

// Returns g h (m^2/s^2), where h is the depth below the highest particle that can fall.
double depth_along(const Scene& scene, const Vec3& gravity) {
  double highest = std::numeric_limits<double>::infinity(), lowest = -highest;
  for (std::size_t i = 0; i < scene.initial_position.size(); ++i) {
    const double depth = gravity.dot(scene.initial_position[i]);
    if (static_cast<int>(i) < scene.dynamic_particles) highest = std::min(highest, depth);
    lowest = std::max(lowest, depth);
  }
  return std::max(0.0, lowest - highest);
}

// True if the air acts on a body or on spheres.
bool has_drag(const Scene& scene) {
  const auto material_drags = [](const MaterialCase& each) {
    return !each.normal_drag.is_zero() || !each.tangential_drag.is_zero();
  };
  const auto spheres_drag = [](const ParticlesCase& each) { return each.drag_coefficient > 0; };
  return std::ranges::any_of(scene.source.material, material_drags) ||
         std::ranges::any_of(scene.source.particles, spheres_drag);
}

double start_speed(const Scene& scene) {
  double speed = 0;
  for (int i = 0; i < scene.heavy_particles; ++i)
    speed = std::max(speed, scene.initial_velocity(i).norm());
  return speed;
}

// Returns the largest speed of the points of a motion that are within `radius` of its centre, at
// any time: a run that goes on beyond time.duration must find the same. The speed between two
// keyframes is largest in the middle, and does not change after the last event.
double largest_speed(const RigidMotion& motion, double radius) {
  constexpr int parts = 16;
  double largest = 0;
  std::optional<MotionEvent> event = MotionEvent{};
  for (double from = 0; event;) {
    event = motion.next_event(from);
    const double to = event ? event->time : from;
    for (int i = 0; i <= parts; ++i) {
      const RigidPose pose = motion.pose(from + (to - from) * i / parts, event && i == parts);
      largest = std::max(largest, pose.velocity.norm() + radius * pose.angular_velocity.norm());
    }
    from = to;
  }
  return largest;
}

double driven_speed(const Scene& scene) {
  double speed = 0;
  for (const PrescribedMotion& held : scene.prescribed)
    if (held.moves) speed = std::max(speed, largest_speed(held.motion, held.radius));
  for (const SceneBody& body : scene.bodies) {
    if (!body.supports) continue;
    body.supports->visit_motions([&](const RigidMotion& motion, double radius) {
      speed = std::max(speed, largest_speed(motion, radius));
    });
  }
  for (const TimedPin& pin : scene.timed_pins) {
    if (!pin.source->motion || pin.particles.empty()) continue;
    std::vector<Vec3> places;
    Vec3 sum = Vec3::Zero();
    for (const int particle : pin.particles) {
      places.push_back(scene.initial_position[particle]);
      sum += places.back();
    }
    const RigidMotion motion(*pin.source->motion, sum / static_cast<double>(places.size()));
    speed = std::max(speed, largest_speed(motion, motion.radius_of(places)));
  }
  return speed;
}

}  // namespace

double expected_impact_speed(const Scene& scene) {
  double wind = 0, depth = 0;
  if (has_drag(scene)) {
    for (const Vec3& value : values_of(scene.source.world.wind))
      wind = std::max(wind, value.norm());
  }
  for (const Vec3& value : values_of(scene.source.world.gravity))
    depth = std::max(depth, depth_along(scene, value));
  const double before = start_speed(scene) + driven_speed(scene) + wind;
  return std::max(least_impact_speed, std::sqrt(before * before + 2 * depth));
}

}  // namespace weft::sim
