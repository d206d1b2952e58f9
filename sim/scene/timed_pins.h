// Pins that take hold or let go during a run.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns true if any pin of the body takes hold after t = 0 or lets go. In this case all pins of
// the body are timed.
bool has_timed_pins(const BodyCase& body);

// Sets the timed pins of a scene and the particles that they hold at t = 0. Moves the particles of
// moving timed pins to their places at t = 0. Precondition: the scene has all its bodies. Throws
// CaseError as select_pinned() (pins.h), and at a clamp that holds no edge.
void add_timed_pins(Scene& scene);

// Returns the particles that timed pins hold after the change of pins at `event` (s). A pin holds
// from its hold_time to its release_time, if it has one. If several pins that hold at this time
// select a particle, the first of these pins in the case holds it. `position` has the positions of
// the dynamic particles (m) at the time `now` (s), which is close to `event`. Pins hold the
// particles that they take over at these positions. `before` has the holds before the change.
std::vector<TimedHold> find_holds(const Scene& whole, double event, double now,
                                  std::span<const Vec3> position,
                                  std::span<const TimedHold> before);

// Returns the scene between the change of pins at `event` (s) and the next change. Its timed pins
// hold the particles of `holds`, and its dynamic particles start at `position` (m). Its pointers to
// materials and pins point into `whole`, which must outlive it.
Scene hold_timed_pins(const Scene& whole, const std::vector<TimedHold>& holds, double event,
                      std::span<const Vec3> position);

// Sets the positions and velocities of pinned particles in a state (StateView,
// sim/motion/dynamics.h) to their prescribed values at `time` (s). Where a prescribed velocity
// jumps, the particles get the velocity after the jump or, if `before_jump`, before it.
void place_pinned(const Scene& scene, double time, bool before_jump, std::span<double> y);

}  // namespace weft::sim
