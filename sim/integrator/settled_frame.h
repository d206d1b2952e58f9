// A state between the ends of a step, which no path check has seen.
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

// Puts `y`, interpolated at `part` (0 .. 1) of a step, on the straight line between its ends where
// contact is on and the path to it is not certain to keep surfaces apart. Fails where that line has
// no frame at `time`, if prescribed points are in its way there. `position` and `velocity`: scratch
// of all particles. Costs a path check, or two.
[[nodiscard]] std::optional<Failure> settle_frame(Dynamics& dynamics, double time, double part,
                                                  const StepEnds& step, std::span<double> y,
                                                  std::vector<Vec3>& position,
                                                  std::vector<Vec3>& velocity);

}  // namespace weft::sim
