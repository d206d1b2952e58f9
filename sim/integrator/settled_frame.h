// The check of states within a step, which the path check of the step has not seen.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/failure.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// The step within which a state is interpolated.
struct StepEnds {
  std::span<const double> start, end;     // states
  std::span<const Vec3> start_positions;  // of all particles; empty without contact
  double start_time = 0;                  // s
};

// Checks the path to `y`, interpolated at `part` (0 .. 1) of a step, if contact is on. If it might
// let surfaces touch, or if `y` exceeds a strain_limit, `y` becomes the point on the straight line
// between the step's ends. Fails if
// prescribed points block that line, too, at `time`. `position` and `velocity` are scratch for all
// particles. Costs one path check or two.
[[nodiscard]] std::optional<Failure> settle_frame(Dynamics& dynamics, double time, double part,
                                                  const StepEnds& step, std::span<double> y,
                                                  std::vector<Vec3>& position,
                                                  std::vector<Vec3>& velocity);

}  // namespace weft::sim
