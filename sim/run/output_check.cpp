#include "sim/run/output_check.h"

#include "sim/accuracy/accuracy_choice.h"
#include "sim/probes/outputs.h"
#include "sim/run/restart.h"
#include "sim/scene/scene.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/frame_recorder.h"

namespace weft::sim {

std::vector<TrajectoryWriter::Series> error_series(const Scene& scene) {
  std::vector<TrajectoryWriter::Series> series;
  for (const SceneBody& body : scene.bodies) {
    if (body.dynamic) series.push_back({"error_estimate_" + body.name, "m"});
  }
  return series;
}

void check_outputs(const Scene& scene, bool estimate_error) {
  if (scene.source.outputs.empty()) return;
  const Simulation simulation(scene);
  std::vector<TrajectoryWriter::Series> more;
  if (estimate_error) more = error_series(scene);
  check_outputs(scene.source.outputs, recorded_contents(simulation, more));
}

void check_outputs_before_pilot(const Case& source, bool estimate_error) {
  if (source.outputs.empty() || !source.awaits_accuracy()) return;
  Case chosen = source;
  choose_accuracy(chosen);
  read_restart(chosen);
  check_outputs(*build_scene(chosen), estimate_error);
}

}  // namespace weft::sim
