// Checks interpolated states. The path check of a step does not cover the states between its ends.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/failure.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// The ends of an accepted step.
struct StepEnds {
  std::span<const double> start, end;  // states at the start and at the end
  // Positions (m) of all particles at the start, as Dynamics::expand() writes them. Empty without
  // contact.
  std::span<const Vec3> start_positions;
  double start_time = 0;  // time of the start (s)
};

// Checks the state `y`, interpolated at `time` (s) and at the fraction `part` (0 to 1) of a step.
// Does nothing without contact and strain_limit. If surfaces might touch on the straight path from
// the start of the step to `y`, or if `y` exceeds a strain_limit, the linear interpolation between
// the step's ends replaces `y`. Returns a failure if surfaces might cross on the path to the
// replacement. `position` and `velocity` are scratch for all particles. Cost: one or two path
// checks.
[[nodiscard]] std::optional<Failure> settle_frame(Dynamics& dynamics, double time, double part,
                                                  const StepEnds& step, std::span<double> y,
                                                  std::vector<Vec3>& position,
                                                  std::vector<Vec3>& velocity);

}  // namespace weft::sim
