// Checks of a case's [outputs] before its run.
#pragma once

#include <vector>

#include "sim/trajectory/trajectory.h"

namespace weft::sim {

struct Scene;

// Returns the series that a run has in addition if it measures its error: one per dynamic body.
std::vector<TrajectoryWriter::Series> error_series(const Scene& scene);

// Throws CaseError if an output of the scene's case is at fault, or asks for what a run of it does
// not record. `estimate_error` says whether the run measures its error. Makes a simulation of the
// scene, unless the case has no outputs.
void check_outputs(const Scene& scene, bool estimate_error);

// Does the same before the pilot of a case that gives time.accuracy, which may take long. The
// method that the calibration chooses stands for that of the pilot. Does nothing for other cases.
void check_outputs_before_pilot(const Case& source, bool estimate_error);

}  // namespace weft::sim
