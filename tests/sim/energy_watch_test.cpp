// Motion that gains energy is found, and motion that does not is left alone.
#include "sim/integrator/energy_watch.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/sim/simulated_case.h"

namespace weft::sim {
namespace {

// Thrown in its own plane, without gravity: what it has, it keeps.
constexpr const char* flying = R"(
[time]
duration = 0.1
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
velocity = [1, 0, 0]
)";

class EnergyWatchTest : public testing::Test {
 protected:
  explicit EnergyWatchTest(const std::string& more = "")
      : case_(std::string(flying) + more),
        state_(case_.dynamics().initial_state()),
        watch_(case_.scene(), case_.dynamics().energies(0, state_)) {}

  // What the watch says of the start with all velocities times a factor.
  std::string with_speed(double factor) {
    std::vector<double> y = state_;
    for (std::size_t i = y.size() / 2; i < y.size(); ++i) y[i] *= factor;
    return watch_.check(0.01, y, case_.dynamics().energies(0, y)).value_or("");
  }

  SimulatedCase case_;
  std::vector<double> state_;
  EnergyWatch watch_;
};

TEST_F(EnergyWatchTest, AllowsTheToleranceAndFivePercentOfTheEnergy) {
  // e = sqrt(3/2) velocity_tolerance + relative_tolerance / sqrt(2), by the root of the mass.
  const TimeCase& options = case_.scene().source.time;
  const double tolerance = 100 * options.position_tolerance;
  const double limit = std::sqrt(1.05 / 2) + std::sqrt(1.5) * tolerance +
                       options.relative_tolerance * std::sqrt(0.5);
  const double factor = limit * std::sqrt(2.0);
  EXPECT_EQ(with_speed(1), "");
  EXPECT_EQ(with_speed(0.999 * factor), "");
  EXPECT_NE(with_speed(1.001 * factor), "");
}

TEST_F(EnergyWatchTest, NamesTheFastestTheTimeAndWhatToDo) {
  const std::string reason = with_speed(2);
  for (const char* word : {"body \"sheet\"", "t = 0.01 s", "tolerances"})
    EXPECT_NE(reason.find(word), std::string::npos) << reason;
}

TEST_F(EnergyWatchTest, FindsWhatIsNotFinite) {
  EXPECT_NE(with_speed(std::numeric_limits<double>::quiet_NaN()), "");
}

// Whoever moves an obstacle may put in what they like.
class EnergyWatchBesideAMovingPlate : public EnergyWatchTest {
 protected:
  EnergyWatchBesideAMovingPlate()
      : EnergyWatchTest(R"(
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [2, 2] }
position = [0, 0, -1]
motion = { velocity = [0, 0, 1] }
)") {}
};

TEST_F(EnergyWatchBesideAMovingPlate, SaysNothing) { EXPECT_EQ(with_speed(10), ""); }

// A fall puts in what gravity does, and no more than a fall by its own size counts beforehand.
TEST(EnergyWatch, LeavesAFallAlone) {
  SimulatedCase fall(flying, {"world.gravity=[0, 0, -9.81]", "time.duration=1"});
  EnergyWatch watch(fall.scene(), fall.dynamics().energies(0, fall.integrator().state()));
  const std::vector<double> y = fall.advance_to(1);
  EXPECT_FALSE(watch.check(1, y, fall.dynamics().energies(1, y)));
  EXPECT_GT(watch.largest_share(), 0.8);
}

}  // namespace
}  // namespace weft::sim
