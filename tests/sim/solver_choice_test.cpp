// Choices that the linear solvers make by counted iterations.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/solver/coarse_matrix_age.h"
#include "sim/solver/hard_systems.h"

namespace weft::sim::solver_choice_test {
namespace {

// Returns the number of systems in a row that the second method takes.
int hard_systems_in_a_row(HardSystems& systems, double gamma) {
  int count = 0;
  while (count < 10000 && systems.take_hard_system(gamma)) ++count;
  return count;
}

TEST(HardSystems, AreFollowedByMoreAndMoreOfTheSecondMethod) {
  HardSystems systems(10, true);
  EXPECT_FALSE(systems.take_hard_system(1e-3));
  for (int expected = 8; expected <= 8192; expected *= 2) {
    EXPECT_TRUE(systems.record(1e-3, 11));
    EXPECT_FALSE(systems.take_hard_system(0.9e-3));
    EXPECT_EQ(hard_systems_in_a_row(systems, 2e-3), std::min(expected, 4096));
    // Systems of a smaller gamma are easier, and say nothing about larger ones.
    EXPECT_FALSE(systems.record(0.9e-3, 3));
  }
  // One of the same gamma that is not hard ends the series.
  EXPECT_FALSE(systems.record(1e-3, 10));
  EXPECT_TRUE(systems.record(1e-3, 11));
  EXPECT_EQ(hard_systems_in_a_row(systems, 1e-3), 8);
}

TEST(HardSystems, AreNoneIfTheSecondMethodIsNotAllowed) {
  HardSystems systems(10, false);
  EXPECT_FALSE(systems.would_be_hard(1000));
  EXPECT_FALSE(systems.record(1e-3, 1000));
  EXPECT_FALSE(systems.take_hard_system(1e-3));
}

// The first solve takes two iterations per digit. Later ones wear the matrices out by more than two
// iterations beyond that rate.
TEST(CoarseMatrices, AreWornOutByExtraIterations) {
  CoarseMatrixAge age;
  age.start(3, 1);
  EXPECT_FALSE(age.is_worn_out_by(50, 1e-2));  // no rate is known
  age.finish(11, 1e-4);
  const auto solve = [&](int iterations) {
    age.start(0, 1);
    EXPECT_EQ(age.is_worn_out_by(iterations, 1e-3), age.is_worn_out() || iterations > 8);
    age.finish(iterations, 1e-3);
  };
  solve(6);  // as the first one
  solve(4);  // fewer do not make up for later ones
  EXPECT_FALSE(age.is_worn_out());
  solve(8);  // two more
  EXPECT_FALSE(age.is_worn_out());
  age.start(0, 1);
  age.finish(7, 1e-3);
  EXPECT_TRUE(age.is_worn_out());
  age.reset();
  EXPECT_FALSE(age.is_worn_out());
}

}  // namespace
}  // namespace weft::sim::solver_choice_test
