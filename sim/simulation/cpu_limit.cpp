#include "sim/simulation/cpu_limit.h"

#include <algorithm>
#include <cstdio>

#include "sim/base/process_time.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

std::string place_of(const Scene& scene, const Integrator& integrator) {
  const std::span<const Vec3> velocity = StateView::of(integrator.state()).velocity;
  const auto fastest = std::max_element(
      velocity.begin(), velocity.end(),
      [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  if (velocity.empty() || fastest->isZero())
    return "of body " + in_quotes(scene.bodies.front().name);
  return "fastest is " + scene.describe_particle(static_cast<int>(fastest - velocity.begin()));
}

std::string short_text(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

}  // namespace

CpuLimit::CpuLimit(double limit)
    : limit_(limit), start_(process_cpu_time()), last_look_(std::chrono::steady_clock::now()) {}

// Steps may take microseconds, and the system's clock of CPU time a third of one.
bool CpuLimit::is_passed() {
  const auto now = std::chrono::steady_clock::now();
  if (now - last_look_ < std::chrono::milliseconds(1)) return false;
  last_look_ = now;
  return process_cpu_time() - start_ > limit_;
}

std::string CpuLimit::reason(const Scene& scene, const Integrator& integrator) const {
  const IntegratorCounts counts = integrator.counts();
  const auto number = [](std::int64_t count) { return std::to_string(count); };
  std::string text =
      "the limit of " + short_text(limit_) +
      " s of CPU time (compute.cpu_limit) is reached at t = " + rounded_text(integrator.time()) +
      " s: " + number(counts.steps) + " steps, the last of " + short_text(integrator.last_step()) +
      " s";
  const auto add = [&](std::int64_t count, const char* what) {
    if (count > 0) text += ", " + number(count) + what;
  };
  add(counts.error_test_failures, " cut because of errors");
  add(counts.convergence_failures, " cut because iterations did not converge");
  add(counts.vetoed_steps, " cut to keep surfaces apart");
  return text + "; " + place_of(scene, integrator);
}

}  // namespace weft::sim
