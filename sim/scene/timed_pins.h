// Pins that take hold or let go during a run.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns true if a pin of the body takes hold or lets go during a run. All pins of the body are
// then timed.
bool has_timed_pins(const BodyCase& body);

// Lists the timed pins of a scene and the particles that they hold at t = 0. Moves the particles of
// moving pins to their places at t = 0. Precondition: the scene has all its bodies. Throws
// CaseError as select_pinned() (pins.h), and at a clamp that holds no edge.
void add_timed_pins(Scene& scene);

// Returns the particles that timed pins hold from `event` (s) on, a time at which pins change. A
// pin holds from its hold_time to its release_time. If several pins select a particle, the first of
// the case holds it. `position` has the dynamic particles (m) at the time `now` (s), which differs
// from `event` by less than a shortest step. A pin holds the particles that it takes over at these
// positions. `before` has the holds until then.
std::vector<TimedHold> find_holds(const Scene& whole, double event, double now,
                                  std::span<const Vec3> position,
                                  std::span<const TimedHold> before);

// Returns the scene from a change of pins at `event` (s) to the next one. Its timed pins hold the
// particles of `holds`, and its dynamic particles start at `position` (m). Its material pointers
// and timed pins point into `whole`, which must outlive it.
Scene hold_timed_pins(const Scene& whole, const std::vector<TimedHold>& holds, double event,
                      std::span<const Vec3> position);

// Sets the positions and velocities of pinned particles in a state (StateView,
// sim/motion/dynamics.h) to their prescribed ones at `time` (s). Where a prescribed velocity jumps,
// they get the one after the jump, or the one before if `before_jump`.
void place_pinned(const Scene& scene, double time, bool before_jump, std::span<double> y);

}  // namespace weft::sim
