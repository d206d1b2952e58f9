// What do 100 static obstacles 100 m away cost a run? Prints the ratio of the CPU times with and
// without them, the two taken in turn, and whether the trajectories have the same bits.
#include <cstdio>
#include <cstdlib>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "sim/case/case_reader.h"
#include "sim/integrator/integrator.h"

namespace weft::bench {

namespace {

using namespace sim;

struct Outcome {
  double cpu = 0;  // s
  std::vector<double> state;
};

Outcome run(const Scene& scene, double duration) {
  Statistics statistics;
  Dynamics dynamics(scene, statistics);
  const auto integrator = make_integrator(scene, dynamics);
  Outcome outcome;
  outcome.cpu = cpu_time_of([&] {
    while (integrator->time() < duration) {
      if (const auto failure = integrator->step()) {
        std::fprintf(stderr, "%s\n", failure->c_str());
        std::exit(1);
      }
    }
  });
  outcome.state.assign(integrator->state().begin(), integrator->state().end());
  return outcome;
}

Case with_far_obstacles(Case source) {
  for (int i = 0; i < 100; ++i) {
    ObstacleCase sphere;
    sphere.name = "far_" + std::to_string(i);
    sphere.shape.type = ShapeType::sphere;
    sphere.shape.radius = 0.5;
    sphere.shape.resolution = {17};
    sphere.position = {100, 2.0 * i - 100, 0};
    source.obstacle.push_back(sphere);
  }
  return source;
}

}  // namespace

int run_far_obstacles() {
  constexpr double duration = 0.25;
  constexpr int repeats = 7;
  const Case source = read_case(std::string(WEFT_CASES_DIR) + "/drape_torus.toml",
                                {"body.sheet.shape.resolution=[33, 33]"});
  const auto alone = build_scene(source), crowded = build_scene(with_far_obstacles(source));
  std::vector<double> times_alone, times_crowded, ratios;
  bool same = true;
  for (int i = 0; i < repeats; ++i) {
    const Outcome first = run(*alone, duration), second = run(*crowded, duration);
    times_alone.push_back(first.cpu);
    times_crowded.push_back(second.cpu);
    ratios.push_back(second.cpu / first.cpu);
    same = same && first.state == second.state;
  }
  std::printf("alone %.3f s, with 100 far obstacles %.3f s (medians of %d, CPU)\n",
              median(times_alone), median(times_crowded), repeats);
  std::printf("ratio %.3f (median of the pairs), trajectories %s\n", median(ratios),
              same ? "the same to the bit" : "DIFFERENT");
  return same ? 0 : 1;
}

}  // namespace weft::bench
