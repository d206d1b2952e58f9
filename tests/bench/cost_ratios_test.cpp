// Cost of an error, and the meaning of each ratio.
#include "bench/cost_ratios.h"

#include <gtest/gtest.h>

namespace weft::bench::cost_ratios_test {
namespace {

CostLadder ladder(const char* method, StepKind kind, std::vector<CostPoint> points) {
  return {method, kind, false, std::move(points)};
}

TEST(CostRatios, CostsAreInterpolatedBetweenRungs) {
  const CostLadder climbed = ladder("a", StepKind::controlled, {{1, 1e-1}, {100, 1e-3}});
  EXPECT_NEAR(cost_at(climbed, 1e-2).value(), 10, 1e-12);
  EXPECT_EQ(cost_at(climbed, 1e-1).value(), 1);
  EXPECT_FALSE(cost_at(climbed, 1e-4));
  // Nothing is known between a failed rung and the next.
  EXPECT_EQ(cost_at(ladder("a", StepKind::controlled, {{1, std::nullopt}, {100, 1e-3}}), 1e-2),
            100);
}

// Explicit steps count as fixed ones: if they are cheapest, tolerances do not look better for it.
TEST(CostRatios, ExplicitStepsCountAsFixedOnes) {
  std::vector<CostLadder> ladders{
      ladder("cvode", StepKind::controlled, {{0.06, 1e-3}}),
      ladder("arkode", StepKind::controlled, {{0.11, 1e-3}}),
      ladder("linear-euler", StepKind::implicit, {{0.30, 1e-3}}),
      ladder("implicit-midpoint", StepKind::implicit, {{0.15, 1e-3}}),
      ladder("verlet", StepKind::explicit_, {{0.015, 1e-3}}),
  };
  CostRatios ratios = cost_ratios(ladders, 1e-3);
  EXPECT_NEAR(ratios.fixed_over_controlled.value(), 0.25, 1e-12);
  EXPECT_NEAR(ratios.implicit_over_controlled.value(), 2.5, 1e-12);
  EXPECT_NEAR(ratios.implicit_over_explicit.value(), 10, 1e-12);
  EXPECT_FALSE(ratios.peers_over_controlled);
  EXPECT_FALSE(cost_ratios(ladders, 1e-4).fixed_over_controlled);

  // Ladders of other libraries do not count as Weft's fixed steps.
  ladders.push_back({"peer", StepKind::implicit, true, {{0.006, 1e-3}}});
  ratios = cost_ratios(ladders, 1e-3);
  EXPECT_NEAR(ratios.fixed_over_controlled.value(), 0.25, 1e-12);
  EXPECT_NEAR(ratios.peers_over_controlled.value(), 0.1, 1e-12);
  EXPECT_NEAR(ratios.peers_over_explicit.value(), 0.4, 1e-12);
}

// Variants of one method are separate ladders: nothing is interpolated between them.
TEST(CostRatios, VariantsAreLaddersOfTheirOwn) {
  const std::vector<CostLadder> variants{
      ladder("soft", StepKind::implicit, {{1, 1e-1}, {2, 5e-2}}),
      ladder("soft", StepKind::implicit, {{4, 2e-2}, {8, 1e-3}}),
  };
  const auto all = [](const CostLadder&) { return true; };
  EXPECT_EQ(least_cost(variants, 2e-2, all), 4);
  EXPECT_EQ(least_cost(variants, 1e-1, all), 1);
}

}  // namespace
}  // namespace weft::bench::cost_ratios_test
