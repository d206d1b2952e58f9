#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string_view>

#include "bench/cloth_runs.h"
#include "bench/contact.h"
#include "bench/dropped_shells.h"
#include "bench/medians.h"
#include "sim/motion/dynamics.h"
#include "sim/run/make_simulation.h"

namespace weft::bench {

namespace {

using namespace sim;

double detection_time(const Simulation& simulation) {
  const PhaseTimes& phases = simulation.statistics().phases;
  return phases.rebuild + phases.traverse + phases.narrow_phase;
}

// Counts the pairs in contact after every step.
class PairCounter : public StepObserver {
 public:
  void after_step(const Simulation& simulation) override {
    pairs_ += static_cast<double>(simulation.contact_pairs());
    ++steps_;
  }
  // Returns the mean since the last call.
  double take_mean() {
    const double mean = steps_ > 0 ? pairs_ / steps_ : 0;
    all_pairs_ += pairs_;
    all_steps_ += steps_;
    pairs_ = steps_ = 0;
    return mean;
  }
  double mean_of_all() const { return all_steps_ > 0 ? all_pairs_ / all_steps_ : 0; }

 private:
  double pairs_ = 0, steps_ = 0, all_pairs_ = 0, all_steps_ = 0;
};

void look(const Simulation& simulation, ContactRun& run) {
  std::vector<Vec3> position, velocity;
  simulation.dynamics().expand_all(simulation.time(), simulation.state(), position, velocity);
  run.crossings += surface_crossings(simulation.scene(), position);
  run.largest_strain = std::max(run.largest_strain, largest_strain(simulation.scene(), position));
  const std::string_view bytes(reinterpret_cast<const char*>(position.data()),
                               position.size() * sizeof(Vec3));
  run.trajectory = 31 * run.trajectory + std::hash<std::string_view>()(bytes);
}

// Advances to the time of a look. Adds a moment unless that fails.
void advance(Simulation& simulation, double seconds, PairCounter& counter, ContactRun& run) {
  const double before = detection_time(simulation);
  const std::int64_t evaluations = simulation.statistics().counters.force_evaluations;
  run.wall += wall_time_of([&] {
    run.cpu += cpu_time_of([&] {
      if (const auto failure = simulation.advance(seconds)) run.failure = failure->text;
    });
  });
  if (!run.failure.empty()) return;
  const std::int64_t made = simulation.statistics().counters.force_evaluations - evaluations;
  const double seconds_each =
      (detection_time(simulation) - before) / static_cast<double>(std::max<std::int64_t>(1, made));
  run.moments.push_back({simulation.time(), counter.take_mean(), 1e6 * seconds_each});
}

}  // namespace

ContactRun measure_contact(const Case& source, int looks) {
  ContactRun run;
  PairCounter counter;
  Simulation simulation = make_simulation(source);
  simulation.add_observer(counter);
  run.vertices = simulation.scene().dynamic_particles;
  look(simulation, run);
  for (int i = 1; i <= looks && run.failure.empty(); ++i) {
    advance(simulation, i * source.time.duration / looks - simulation.time(), counter, run);
    if (run.failure.empty()) look(simulation, run);
  }
  const Statistics& statistics = simulation.statistics();
  const IntegratorCounts counts = simulation.counts();
  run.simulated = simulation.time();
  run.detection = detection_time(simulation);
  run.linear_solve = statistics.phases.linear_solve;
  run.steps = static_cast<double>(counts.steps);
  run.vetoed = static_cast<double>(counts.vetoed_steps);
  run.evaluations = static_cast<double>(statistics.counters.force_evaluations);
  run.pairs_measured = static_cast<double>(statistics.counters.narrow_phase_calls);
  run.pairs_in_contact = counter.mean_of_all();
  run.solves = static_cast<double>(counts.newton_iterations);
  run.iterations = static_cast<double>(counts.linear_iterations);
  run.factorisations = static_cast<double>(statistics.counters.sparse_factorisations);
  return run;
}

}  // namespace weft::bench
