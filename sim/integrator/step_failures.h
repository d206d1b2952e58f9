// The messages of failed steps, for all methods.
#pragma once

#include <optional>
#include <string>

#include "sim/base/failure.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// The reason why a trial of a step fails.
enum class StepTrouble {
  none,
  not_converged,
  surfaces,
  overstretched,
  not_finite,
  error_too_large,
  unstable
};

// Returns the trouble that a fault of a state or a path is.
StepTrouble trouble_of(const ContactFault& fault);

// Returns the pair with the smallest gap in the state `y` at `time` (s) as a fault, or nothing if
// that gap is more than a hundredth of contact.range. At the start, half of contact.range counts:
// bodies that start so close are thrown apart. Evaluates the forces.
std::optional<ContactFault> pressed_surfaces(Dynamics& dynamics, double time,
                                             std::span<const double> y);
// Returns the trouble of a step that fails by `trouble` between such surfaces, if there are any:
// they end the run, whatever fails first.
StepTrouble trouble_with(const std::optional<ContactFault>& pressed, StepTrouble trouble);

// The time of a failure, and its cause: a contact fault or, without one, a particle.
struct FailurePlace {
  double time = 0;  // s
  const std::optional<ContactFault>& fault;
  // The particle with the largest error; -1 if unknown. If the step is unstable, this is the
  // fastest particle. In a search for an equilibrium, it is the particle farthest from balance.
  int particle = -1;
  // True if ShortSteps::are_allowed().
  bool may_be_short = false;
};

// Returns a failure with the text "WHAT at t = TIME s: PLACE", or without ": PLACE" if neither a
// fault nor a particle is known.
Failure placed_failure(Failure::Kind kind, const std::string& what, const FailurePlace& place,
                       const Scene& scene);

// Returns the failure of a step that fails by `trouble` at every length down to the shortest one.
// If the method finds equilibria, the text names loads instead of steps.
Failure shortest_step_failure(StepTrouble trouble, const FailurePlace& place, const Scene& scene);

}  // namespace weft::sim
