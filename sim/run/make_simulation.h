// Makes simulations from cases.
#pragma once

#include "sim/accuracy/accuracy_pilot.h"
#include "sim/simulation/simulation.h"

namespace weft::sim {

// Makes a simulation of the case. If the case gives time.accuracy, correct_accuracy() first chooses
// the method and its settings (sim/accuracy/accuracy_pilot.h). Then the scene is built and its
// initial state checked. Throws CaseError for a case that cannot be simulated. Throws
// std::runtime_error if the pilot was stopped or reached compute.cpu_limit.
Simulation make_simulation(Case source, const PilotOptions& options = {});

}  // namespace weft::sim
