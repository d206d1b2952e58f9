#include "bench/timed_run.h"

#include <chrono>
#include <optional>

#include "bench/medians.h"
#include "sim/case/case_text.h"

namespace weft::bench {

namespace {

using namespace sim;

// CPU time (s) since it was made. Asked after every step, the system's clock of it would be a few
// percent of what the cheapest steps take; it cannot have passed more than all threads together.
class CpuLimit {
 public:
  CpuLimit(double limit, int threads) : limit_(limit), threads_(threads) {}
  bool is_passed() const {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start_;
    return wall.count() * threads_ > limit_ && seconds(CLOCK_PROCESS_CPUTIME_ID) - start_ > limit_;
  }

 private:
  double limit_;  // s
  int threads_;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  double start_ = seconds(CLOCK_PROCESS_CPUTIME_ID);
};

// The failure, if any. Frames are interpolated as a recorder would.
std::string advance(Dynamics& dynamics, Integrator& integrator, std::span<const double> times,
                    double budget, TimedRun& run) {
  std::vector<double> state(dynamics.state_size());
  const CpuLimit limit(budget, dynamics.threads());
  std::size_t next = 0;
  while (next < times.size()) {
    if (auto failure = integrator.step()) return *failure;
    std::optional<Energies> energies;
    for (; next < times.size() && times[next] <= integrator.time(); ++next) {
      integrator.state_at(times[next], state);
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
