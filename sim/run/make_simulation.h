// Makes simulations from cases.
#pragma once

#include "sim/accuracy/accuracy_pilot.h"
#include "sim/simulation/simulation.h"

namespace weft::sim {

// Settles time.accuracy as `weft run` does, by pilot runs if it is given (accuracy_pilot.h). Then
// builds the scene and checks its initial state. Throws CaseError for a case that cannot be
// simulated, and std::runtime_error if the pilot was stopped or reached compute.cpu_limit.
Simulation make_simulation(Case source, const PilotOptions& options = {});

}  // namespace weft::sim
