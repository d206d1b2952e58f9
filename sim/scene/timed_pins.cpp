#include "sim/scene/timed_pins.h"

#include <algorithm>
#include <cassert>

#include "sim/scene/pins.h"
#include "sim/scene/shell_body.h"

namespace weft::sim {

namespace {

bool holds_at(const PinCase& pin, double time) {
  return pin.hold_time <= time && (!pin.release_time || time < *pin.release_time);
}

PrescribedMotion prescribed_by(const TimedHold& hold, const TimedPin& timed) {
  const PinCase& pin = *timed.source;
  PrescribedMotion held;
  held.pin = timed.number;
  held.particles = hold.particles;
  held.start = hold.start;
  held.clamped = hold.clamped;
  held.moves = pin.motion.has_value();
  if (held.moves) {
    held.motion = RigidMotion(*pin.motion, hold.centre);
    held.radius = held.motion.radius_of(held.start);
  }
  return held;
}

// Returns the mean (m) of the image points that the pin names and holds. If other pins hold all of
// these, returns the mean of the rows that a clamp adds. `held` is sorted.
Vec3 centre_of(const TimedPin& pin, const SceneBody& body, const std::vector<int>& held,
               std::span<const Vec3> position) {
  std::vector<int> points;
  for (const int point : pin.points) {
    if (std::ranges::binary_search(held, body.first_particle + point)) points.push_back(point);
  }
  if (points.empty()) {
    for (const int particle : held) points.push_back(particle - body.first_particle);
  }
  return mean_of_image_points(body, position.subspan(body.first_particle, body.particle_count()),
                              points);
}

// Returns the edges at the rim of a clamp. An edge that the clamp held before keeps its ghost.
std::vector<ClampedEdge> clamped_edges(const SceneBody& body, const TimedHold& hold,
                                       const RigidPose& pose, std::span<const Vec3> position,
                                       const TimedHold* before) {
  std::vector<ClampedEdge> edges = find_clamped_edges(body, hold.particles, position, pose);
  if (before == nullptr) return edges;
  for (ClampedEdge& edge : edges) {
    for (const ClampedEdge& earlier : before->clamped) {
      if (earlier.triangle == edge.triangle && earlier.edge == edge.edge)
        edge.ghost = earlier.ghost;
    }
  }
  return edges;
}

// Returns the hold of a pin on `particles`. `before` is the previous hold of the pin, or null if
// the pin held nothing before.
TimedHold hold_of(int pin, const TimedPin& timed, const SceneBody& body, std::vector<int> particles,
                  double now, std::span<const Vec3> position, const TimedHold* before) {
  const PinCase& source = *timed.source;
  TimedHold hold;
  hold.pin = pin;
  hold.particles = std::move(particles);
  hold.centre =
      before != nullptr ? before->centre : centre_of(timed, body, hold.particles, position);
  RigidPose pose;
  // At t = 0 the start of a particle is its place in the case, even if the motion of the pin begins
  // elsewhere.
  if (source.motion && now > 0) pose = RigidMotion(*source.motion, hold.centre).pose(now);
  for (const int particle : hold.particles) {
    if (before != nullptr) {
      const auto found = std::ranges::lower_bound(before->particles, particle);
      if (found != before->particles.end() && *found == particle) {
        hold.start.push_back(before->start[found - before->particles.begin()]);
        continue;
      }
    }
    const bool is_at_rest = !source.motion || now == 0;
    hold.start.push_back(is_at_rest ? position[particle] : pose.start_of(position[particle]));
  }
  if (source.clamp && !body.spline)
    hold.clamped = clamped_edges(body, hold, pose, position, before);
  return hold;
}

}  // namespace

bool has_timed_pins(const BodyCase& body) {
  return std::ranges::any_of(
      body.pin, [](const PinCase& pin) { return pin.hold_time > 0 || pin.release_time; });
}

void add_timed_pins(Scene& scene) {
  for (std::size_t b = 0; b < scene.source.body.size(); ++b) {
    const BodyCase& from = scene.source.body[b];
    if (!has_timed_pins(from)) continue;
    const SceneBody& body = scene.bodies[scene.case_order[b]];
    const auto positions = std::span<const Vec3>(scene.initial_position)
                               .subspan(body.first_particle, body.particle_count());
    for (const PinCase& pin : from.pin) {
      TimedPin timed{&pin,
                     static_cast<int>(&pin - from.pin.data()),
                     scene.case_order[b],
                     select_pinned(pin, body, positions),
                     {}};
      timed.points = timed.particles;
      if (pin.clamp && body.spline)
        timed.particles = with_clamped_rows(body, pin, std::move(timed.particles));
      for (int& particle : timed.particles) particle += body.first_particle;
      if (pin.clamp && !body.spline) {
        require_clamped_edges(
            pin, find_clamped_edges(body, timed.particles, scene.initial_position, {}));
      }
      scene.timed_pins.push_back(std::move(timed));
    }
  }
  scene.first_holds = find_holds(scene, 0, 0, scene.initial_position, {});
  for (const TimedHold& hold : scene.first_holds) {
    const PrescribedMotion held = prescribed_by(hold, scene.timed_pins[hold.pin]);
    if (!held.moves) continue;
    const RigidPose pose = held.motion.pose(0);
    for (std::size_t i = 0; i < held.particles.size(); ++i)
      scene.initial_position[held.particles[i]] = pose.place(held.start[i]);
  }
}

std::vector<TimedHold> find_holds(const Scene& whole, double event, double now,
                                  std::span<const Vec3> position,
                                  std::span<const TimedHold> before) {
  std::vector<char> taken(whole.dynamic_particles, 0);
  std::vector<TimedHold> holds;
  for (std::size_t p = 0; p < whole.timed_pins.size(); ++p) {
    const TimedPin& pin = whole.timed_pins[p];
    if (!holds_at(*pin.source, event)) continue;
    std::vector<int> particles;
    for (const int particle : pin.particles) {
      if (taken[particle] == 0) particles.push_back(particle);
      taken[particle] = 1;
    }
    if (particles.empty()) continue;
    const int index = static_cast<int>(p);
    const auto found = std::ranges::find(before, index, &TimedHold::pin);
    holds.push_back(hold_of(index, pin, whole.bodies[pin.body], std::move(particles), now, position,
                            found == before.end() ? nullptr : &*found));
  }
  return holds;
}

Scene hold_timed_pins(const Scene& whole, const std::vector<TimedHold>& holds, double event,
                      std::span<const Vec3> position) {
  assert(static_cast<int>(position.size()) >= whole.dynamic_particles);
  Scene scene = whole;
  std::copy_n(position.begin(), whole.dynamic_particles, scene.initial_position.begin());
  for (const TimedHold& hold : holds) {
    for (const int particle : hold.particles) scene.pinned[particle] = 1;
    scene.prescribed.push_back(prescribed_by(hold, whole.timed_pins[hold.pin]));
  }
  for (const TimedPin& pin : whole.timed_pins) {
    for (const double time : {pin.source->hold_time, pin.source->release_time.value_or(0)}) {
      if (time > event) scene.pins_change_at = std::min(scene.pins_change_at, time);
    }
  }
  return scene;
}

void place_pinned(const Scene& scene, double time, bool before_jump, std::span<double> y) {
  auto* const position = reinterpret_cast<Vec3*>(y.data());
  Vec3* const velocity = position + scene.dynamic_particles;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (held.particles.empty() || held.particles.front() >= scene.dynamic_particles) continue;
    std::vector<Vec3> place(held.start), rate(held.start.size(), Vec3::Zero());
    if (held.moves) held.motion.apply(time, held.start, place, rate, before_jump);
    for (std::size_t i = 0; i < held.particles.size(); ++i) {
      position[held.particles[i]] = place[i];
      velocity[held.particles[i]] = rate[i];
    }
  }
}

}  // namespace weft::sim
