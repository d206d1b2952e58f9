// Checks states interpolated within a step, which the path check of the step does not cover.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/failure.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// The accepted step within which a state is interpolated.
struct StepEnds {
  std::span<const double> start, end;     // states
  std::span<const Vec3> start_positions;  // of all particles; empty without contact
  double start_time = 0;                  // s
};

// Makes the state `y`, interpolated at `part` (0 to 1) of a step, safe if contact is on or
// membranes have a strain_limit. If surfaces might touch on the path from the start of the step to
// `y`, or if `y` exceeds a strain_limit, the linear interpolation of the step's ends replaces `y`.
// Returns a failure if surfaces might cross on that path too, with prescribed points at their
// places at `time`. `position` and `velocity` are scratch for all particles. Cost: one or two path
// checks.
[[nodiscard]] std::optional<Failure> settle_frame(Dynamics& dynamics, double time, double part,
                                                  const StepEnds& step, std::span<double> y,
                                                  std::vector<Vec3>& position,
                                                  std::vector<Vec3>& velocity);

}  // namespace weft::sim
