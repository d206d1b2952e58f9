// The door to simulations from a case.
#pragma once

#include "sim/accuracy/accuracy_pilot.h"
#include "sim/simulation/simulation.h"

namespace weft::sim {

// Settles time.accuracy as `weft run` does, by pilot runs where it is given (accuracy_pilot.h),
// builds the scene and checks its initial state. Throws CaseError for a case that cannot be
// simulated, and std::runtime_error where the pilot was stopped or reached compute.cpu_limit.
Simulation make_simulation(Case source, const PilotOptions& options = {});

}  // namespace weft::sim
