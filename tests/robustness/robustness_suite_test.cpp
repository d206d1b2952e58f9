// The suite `robustness`: every shipped case and every scene of layers, folds and knots, ten times
// each, turned at random and disturbed by 1e-6 of its size. No surface crosses another at any
// accepted step, no number is not finite, no run stalls, no energy grows unfed. One fault fails.
//
// WEFT_ROBUSTNESS=whole makes ten runs of each scene, and WEFT_ROBUSTNESS=N makes N. Without it,
// one of each is made for at most a tenth of its time.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "bench/child_runs.h"
#include "sim/case/case_reader.h"
#include "tests/robustness/robustness_run.h"
#include "tests/robustness/robustness_scenes.h"
#include "tests/robustness/varied_case.h"

namespace weft::robustness::robustness_suite_test {
namespace {

constexpr int whole_count = 10;
// Part of the time that is simulated without WEFT_ROBUSTNESS.
constexpr double short_part = 0.1;

// Returns the number of runs of each scene that the environment asks for, or 0.
int asked_runs() {
  const char* value = std::getenv("WEFT_ROBUSTNESS");
  if (value == nullptr || *value == 0) return 0;
  return std::string(value) == "whole" ? whole_count : std::max(1, std::atoi(value));
}

class Robustness : public testing::TestWithParam<RobustScene> {};

TEST_P(Robustness, HoldsUnderRotationAndJitter) {
  const RobustScene& scene = GetParam();
  // Results do not depend on the number of threads, but CPU time does.
  const sim::Case source = sim::read_case(scene.path, {"compute.threads=1"});
  const int asked = asked_runs();
  const double whole = scene.end > 0 ? scene.end : source.time.duration;
  const double end = asked > 0 ? whole : short_part * whole;
  bench::run_children(
      std::max(1, asked), 1, [](std::size_t) { return run_limit + 20; },
      [&](std::size_t seed) {
        return to_text(judge(varied(source, static_cast<std::uint32_t>(seed)), end));
      },
      [&](std::size_t seed, const bench::ChildEnd& child) {
        Judgement judged = from_text(child.result);
        if (!child.is_well)
          judged.fault = "crashed or hung, signal " + std::to_string(child.signal);
        std::printf("%-22s %zu  %8.4f s  %7ld steps %5ld vetoed  %7.2f s CPU  gained %.1e  %s\n",
                    scene.name.c_str(), seed, judged.time, judged.steps, judged.vetoed,
                    judged.cpu_time, judged.gained_share, judged.fault.c_str());
        std::fflush(stdout);
        EXPECT_EQ(judged.fault, "") << scene.name << ", seed " << seed;
      });
}

INSTANTIATE_TEST_SUITE_P(Scenes, Robustness, testing::ValuesIn(robust_scenes(WEFT_CASES_DIR)),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace weft::robustness::robustness_suite_test
