// Makes simulations from cases.
#pragma once

#include "sim/accuracy/accuracy_pilot.h"
#include "sim/simulation/simulation.h"

namespace weft::sim {

// Makes a simulation of the case. First it settles time.accuracy as `weft run` does, if the case
// gives that key (accuracy_pilot.h). Then it builds the scene and checks the initial state. Throws
// CaseError for a case that cannot be simulated. Throws std::runtime_error if the pilot was stopped
// or reached compute.cpu_limit.
Simulation make_simulation(Case source, const PilotOptions& options = {});

}  // namespace weft::sim
