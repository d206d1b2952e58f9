// Pins that take hold or let go during a run.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// True if a pin of the body takes hold or lets go during a run. All its pins are then timed.
bool has_timed_pins(const BodyCase& body);

// Lists the timed pins of a scene that has all its bodies, and what they hold at t = 0. Puts the
// particles of moving pins where the motion starts. Throws CaseError as select_pinned() (pins.h).
void add_timed_pins(Scene& scene);

// Returns the particles that timed pins hold from a change of pins at `event` (s) on. Pins hold
// from their hold_time to their release_time. Of several pins that name a particle, the first of
// the case holds it. A pin holds the particles that it takes over where they are: at `position` (m,
// dynamic particles) at the time `now` (s), within a shortest step of `event`. `before` has the
// holds until then.
std::vector<TimedHold> find_holds(const Scene& whole, double event, double now,
                                  std::span<const Vec3> position,
                                  std::span<const TimedHold> before);

// Returns the scene from a change of pins at `event` (s) to the next one: with these holds, and
// with dynamic particles at `position` (m) to start from. Its material pointers and timed pins
// point into `whole`, which must outlive it.
Scene hold_timed_pins(const Scene& whole, const std::vector<TimedHold>& holds, double event,
                      std::span<const Vec3> position);

// Puts the pinned particles of a state (StateView, sim/motion/dynamics.h) where they are held at
// `time`. Where a prescribed velocity jumps, they get the one after the jump, or with `before_jump`
// the one before.
void place_pinned(const Scene& scene, double time, bool before_jump, std::span<double> y);

}  // namespace weft::sim
