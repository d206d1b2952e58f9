#include "bench/timed_run.h"

#include <optional>

#include "bench/medians.h"
#include "sim/case/case_text.h"
#include "sim/simulation/cpu_limit.h"

namespace weft::bench {

namespace {

using namespace sim;

// The failure, if any. Frames are interpolated as a recorder would.
std::string advance(Dynamics& dynamics, Integrator& integrator, std::span<const double> times,
                    double budget, TimedRun& run) {
  std::vector<double> state(dynamics.state_size());
  CpuLimit limit(budget);
  std::size_t next = 0;
  while (next < times.size()) {
    if (auto failure = integrator.step()) return *failure;
    std::optional<Energies> energies;
    for (; next < times.size() && times[next] <= integrator.time(); ++next) {
      if (auto failure = integrator.state_at(times[next], state)) return *failure;
      const std::span<const Vec3> position = StateView::of(state).position;
      run.positions.emplace_back(position.begin(), position.end());
      if (!energies) energies = dynamics.energies(integrator.time(), integrator.state());
      run.energies.push_back(*energies);
    }
    if (limit.is_passed())
      return "over the budget of " + number_text(budget) +
             " s at t = " + number_text(integrator.time()) + " s";
  }
  return {};
}

}  // namespace

TimedRun simulate(const Case& source, std::span<const double> times, double budget) {
  const auto scene = build_scene(source);
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  const auto integrator = make_integrator(*scene, dynamics);
  TimedRun run;
  run.energies.push_back(dynamics.energies(0, integrator->state()));
  run.cpu = cpu_time_of([&] { run.failure = advance(dynamics, *integrator, times, budget, run); });
  run.counts = integrator->counts();
  return run;
}

}  // namespace weft::bench
