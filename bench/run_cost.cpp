#include "bench/run_cost.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <vector>

#include "bench/medians.h"
#include "bench/run_apart.h"
#include "sim/accuracy/accuracy_choice.h"
#include "sim/scene/scene.h"
#include "sim/simulation/simulation.h"

namespace weft::bench {

namespace {

using namespace sim;

RunCost measure(Case source, int steps) {
  choose_accuracy(source);
  Simulation simulation(build_scene(source));
  RunCost cost{.vertices = simulation.scene().dynamic_particles};
  std::vector<double> times;
  for (; cost.steps < steps; ++cost.steps) {
    std::optional<Failure> failure;
    times.push_back(cpu_time_of([&] { failure = simulation.step(); }));
    if (!failure) continue;
    std::fprintf(stderr, "%d vertices: %s\n", cost.vertices, failure->text.c_str());
    break;
  }
  cost.cpu = median(times);
  const double taken = std::max(1, cost.steps);
  cost.linear_iterations = static_cast<double>(simulation.counts().linear_iterations) / taken;
  cost.linear_solves = static_cast<double>(simulation.counts().newton_iterations) / taken;
  return cost;
}

}  // namespace

RunCost cost_of_run(const Case& source, int steps) {
  const ApartResult end = run_apart([&] {
    const RunCost cost = measure(source, steps);
    std::string bytes(sizeof cost, '\0');
    std::memcpy(bytes.data(), &cost, sizeof cost);
    return bytes;
  });
  RunCost cost;
  std::memcpy(&cost, end.result.data(), sizeof cost);
  cost.peak_bytes = end.peak_bytes;
  return cost;
}

Case with_image(Case source, int n) {
  source.body.at(0).shape.resolution = {n, n};
  return source;
}

}  // namespace weft::bench
