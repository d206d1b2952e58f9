#include "sim/run/make_simulation.h"

#include <stdexcept>

#include "sim/run/initial_state.h"
#include "sim/run/restart.h"
#include "sim/scene/scene.h"

namespace weft::sim {

Simulation make_simulation(Case source, const PilotOptions& options) {
  read_restart(source);
  const PilotReport pilot = correct_accuracy(source, options);
  if (pilot.ended_run()) {
    throw std::runtime_error(pilot.interrupted ? "the pilot run of time.accuracy was stopped"
                                               : pilot.limit_reason);
  }
  auto scene = build_scene(source);
  check_initial_state(*scene);
  return Simulation(std::move(scene));
}

}  // namespace weft::sim
