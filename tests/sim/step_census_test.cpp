// The census of steps counts every accepted step once, by its length and by what limited it.
#include <numeric>

#include "simulated_case.h"

namespace weft::sim::step_census_test {
namespace {

// A sheet falls on a ball.
const std::string falling_sheet = R"(
[time]
duration = 0.06
[contact]
friction = 0.3
[material.cloth]
density = 0.2
membrane_stiffness = 300
bending_stiffness = 1e-5
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0.01, 0.02, 0.058]
velocity = [0, 0, -1]
shape = { type = "rectangle", size = [0.12, 0.1], resolution = [7, 9] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.05, resolution = [9] }
)";

std::int64_t limited_by(const StepCensus& census, StepLimit limit) {
  return census.by_limit[static_cast<std::size_t>(limit)];
}

template <std::size_t size>
std::int64_t sum(const std::array<std::int64_t, size>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

TEST(StepCensus, ClassesHoldTheirLowerEnds) {
  StepCensus census;
  for (const double length : {0.0, 0.9e-7, 1e-7, 1.99e-4, 2e-4, 0.9, 1.0, 50.0})
    census.add(length, StepLimit::given);
  const auto steps_below = [&](double end) {
    const auto place = std::find(census.ends.begin(), census.ends.end(), end);
    return census.by_length[static_cast<std::size_t>(place - census.ends.begin())];
  };
  EXPECT_EQ(steps_below(1e-7), 2);
  EXPECT_EQ(steps_below(2e-7), 1);
  EXPECT_EQ(steps_below(2e-4), 1);
  EXPECT_EQ(steps_below(5e-4), 1);
  EXPECT_EQ(steps_below(1.0), 1);
  EXPECT_EQ(census.by_length.back(), 2);
  EXPECT_EQ(limited_by(census, StepLimit::given), 8);
  census.add(1.001 - 1, StepLimit::given);  // less than 1e-3 by rounding
  EXPECT_EQ(steps_below(1e-3), 0);
  EXPECT_EQ(steps_below(2e-3), 1);
  StepCensus twice = census;
  twice += census;
  EXPECT_EQ(sum(twice.by_length), 18);
  EXPECT_EQ(sum(twice.by_limit), 18);
}

TEST(StepCensus, NamesTheLargestPartOfTheError) {
  for (const auto& [contact, velocity, limit] :
       {std::tuple(0, 0, StepLimit::free_position_error),
        std::tuple(0, 1, StepLimit::free_velocity_error),
        std::tuple(1, 0, StepLimit::contact_position_error),
        std::tuple(1, 1, StepLimit::contact_velocity_error)}) {
    ErrorParts parts;
    for (auto& each : parts.sum) each = {1.0, 2.0};
    parts.sum[contact][velocity] = 3;
    EXPECT_EQ(parts.largest(), limit) << contact << velocity;
  }
}

TEST(StepCensus, CountsEveryStepOnce) {
  for (const char* name : {"cvode", "arkode", "euler", "implicit_midpoint"}) {
    Overrides overrides = method(name);
    if (name == std::string("implicit_midpoint")) overrides.emplace_back("time.step=1e-3");
    SimulatedCase sim(falling_sheet, overrides);
    static_cast<void>(sim.advance_to(0.06));
    const IntegratorCounts counts = sim.integrator().counts();
    EXPECT_GT(counts.steps, 0) << name;
    EXPECT_EQ(sum(counts.census.by_length), counts.steps) << name;
    EXPECT_EQ(sum(counts.census.by_limit), counts.steps) << name;
  }
}

TEST(StepCensus, TellsContactFromFreeFlight) {
  SimulatedCase sim(falling_sheet);
  const auto of_contact = [&] {
    const StepCensus census = sim.integrator().counts().census;
    return limited_by(census, StepLimit::contact_position_error) +
           limited_by(census, StepLimit::contact_velocity_error);
  };
  static_cast<void>(sim.advance_to(0.003));  // before anything is in reach
  EXPECT_EQ(of_contact(), 0);
  static_cast<void>(sim.advance_to(0.06));
  EXPECT_GT(of_contact(), 0);
}

TEST(StepCensus, FixedStepsAreGivenUnlessTheyFail) {
  SimulatedCase sim(falling_sheet, method("euler", {"time.step=5e-4"}));
  static_cast<void>(sim.advance_to(0.06));
  const IntegratorCounts counts = sim.integrator().counts();
  EXPECT_EQ(limited_by(counts.census, StepLimit::given), counts.steps);
}

}  // namespace
}  // namespace weft::sim::step_census_test
