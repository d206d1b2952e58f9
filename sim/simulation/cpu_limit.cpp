#include "sim/simulation/cpu_limit.h"

#include <algorithm>
#include <cstdio>

#include "sim/base/process_time.h"
#include "sim/case/case_text.h"
#include "sim/integrator/integrator.h"

namespace weft::sim {

namespace {

// Returns the fastest particle, or -1 if all particles are at rest.
int fastest_particle(const Simulation& simulation) {
  const std::span<const Vec3> velocity = StateView::of(simulation.state()).velocity;
  const auto fastest = std::max_element(
      velocity.begin(), velocity.end(),
      [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  if (velocity.empty() || fastest->isZero()) return -1;
  return static_cast<int>(fastest - velocity.begin());
}

std::string short_text(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

}  // namespace

CpuLimit::CpuLimit(double limit)
    : limit_(limit), start_(process_cpu_time()), last_look_(std::chrono::steady_clock::now()) {}

// Reads the clock of CPU time rarely, because reading it takes long compared with a step of
// microseconds.
bool CpuLimit::is_passed() {
  const auto now = std::chrono::steady_clock::now();
  if (now - last_look_ < std::chrono::milliseconds(1)) return false;
  last_look_ = now;
  return process_cpu_time() - start_ > limit_;
}

Failure CpuLimit::failure(const Simulation& simulation) const {
  const IntegratorCounts counts = simulation.counts();
  const auto number = [](std::int64_t count) { return std::to_string(count); };
  std::string text =
      "the limit of " + short_text(limit_) +
      " s of CPU time (compute.cpu_limit) is reached at t = " + rounded_text(simulation.time()) +
      " s: " + number(counts.steps) + " steps, the last of " +
      short_text(simulation.integrator().last_step()) + " s";
  const auto add = [&](std::int64_t count, const char* what) {
    if (count > 0) text += ", " + number(count) + what;
  };
  add(counts.error_test_failures, " cut because of errors");
  add(counts.convergence_failures, " cut because iterations did not converge");
  add(counts.vetoed_steps, " cut to keep surfaces apart");
  const int fastest = fastest_particle(simulation);
  text += fastest < 0 ? "; of body " + in_quotes(simulation.scene().bodies.front().name)
                      : "; fastest is " + simulation.scene().describe_particle(fastest);
  return {Failure::Kind::cpu_limit, simulation.time(), fastest, text};
}

}  // namespace weft::sim
