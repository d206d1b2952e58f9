#include "bench/timed_run.h"

#include <optional>

#include "bench/medians.h"
#include "sim/case/case_text.h"
#include "sim/motion/dynamics.h"
#include "sim/scene/scene.h"
#include "sim/simulation/cpu_limit.h"
#include "sim/simulation/simulation.h"

namespace weft::bench {

namespace {

using namespace sim;

// Returns the failure in words, if any. Frames are interpolated as a recorder would.
std::string advance(Simulation& simulation, std::span<const double> times, double budget,
                    TimedRun& run) {
  std::vector<double> state(simulation.state().size());
  CpuLimit limit(budget);
  std::size_t next = 0;
  while (next < times.size()) {
    if (const auto failure = simulation.step()) return failure->text;
    const double now = simulation.time();
    std::optional<Energies> energies;
    for (; next < times.size() && times[next] <= now; ++next) {
      if (const auto failure = simulation.state_at(times[next], state)) return failure->text;
      const std::span<const Vec3> position = StateView::of(state).position;
      run.positions.emplace_back(position.begin(), position.end());
      if (!energies) energies = simulation.dynamics().energies(now, simulation.state());
      run.energies.push_back(*energies);
    }
    if (limit.is_passed())
      return "over the budget of " + number_text(budget) + " s at t = " + number_text(now) + " s";
  }
  return {};
}

}  // namespace

TimedRun simulate(const Case& source, std::span<const double> times, double budget) {
  Simulation simulation(build_scene(source));
  TimedRun run;
  run.energies.push_back(simulation.energies());
  run.cpu = cpu_time_of([&] { run.failure = advance(simulation, times, budget, run); });
  run.counts = simulation.counts();
  return run;
}

}  // namespace weft::bench
