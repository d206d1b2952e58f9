// The watch detects motion that gains energy, and accepts motion that does not.
#include "sim/motion/energy_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "sim/run/make_simulation.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::energy_watch_test {
namespace {

// The sheet is thrown in its own plane without gravity, and keeps its energy.
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
        watch_(case_.dynamics(), state_) {}

  // Returns the watch's message for the start with all velocities times a factor.
  std::string with_speed(double factor) {
    std::vector<double> y = state_;
    for (std::size_t i = y.size() / 2; i < y.size(); ++i) y[i] *= factor;
    const auto failure = watch_.check(0.01, y, case_.dynamics().energies(0, y));
    return failure ? failure->text : "";
  }

  SimulatedCase case_;
  std::vector<double> state_;
  EnergyWatch watch_;
};

TEST_F(EnergyWatchTest, AllowsTheToleranceAndFivePercentOfTheEnergy) {
  // e = (sqrt(3/2) velocity_tolerance + relative_tolerance / sqrt(2)) sqrt(mass).
  const TimeCase& options = case_.scene().source.time;
  const double tolerance = 100 * options.position_tolerance;
  const double limit = std::sqrt(1.05 / 2) + std::sqrt(1.5) * tolerance +
                       options.relative_tolerance * std::sqrt(0.5);
  const double factor = limit * std::sqrt(2.0);
  EXPECT_EQ(with_speed(1), "");
  EXPECT_EQ(with_speed(0.999 * factor), "");
  EXPECT_NE(with_speed(1.001 * factor), "");
}

// A tenth of what the test allows for errors is a gain, before the rest of it ends a run.
TEST_F(EnergyWatchTest, NoticesAGainBeforeItEndsARun) {
  const TimeCase& options = case_.scene().source.time;
  const double tolerance = 100 * options.position_tolerance;
  const double limit = std::sqrt(1.05) + std::sqrt(3.0) * tolerance + options.relative_tolerance;
  for (const auto& [factor, gains] : {std::pair(0.9, false),
                                      {1.0, false},
                                      {0.91 + 0.09 * limit, false},
                                      {0.89 + 0.11 * limit, true},
                                      {0.5 + 0.5 * limit, true}}) {
    EXPECT_EQ(with_speed(factor), "") << factor;
    EXPECT_EQ(watch_.has_gain(), gains) << factor;
  }
}

TEST_F(EnergyWatchTest, NamesTheFastestTheTimeAndWhatToDo) {
  const std::string reason = with_speed(2);
  for (const char* word : {"body \"sheet\"", "t = 0.01 s", "tolerances"})
    EXPECT_NE(reason.find(word), std::string::npos) << reason;
}

TEST_F(EnergyWatchTest, FindsWhatIsNotFinite) {
  EXPECT_NE(with_speed(std::numeric_limits<double>::quiet_NaN()), "");
}

// An obstacle that moves without touching anything puts nothing in.
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

TEST_F(EnergyWatchBesideAMovingPlate, IsNotBlinded) {
  EXPECT_EQ(with_speed(1), "");
  EXPECT_NE(with_speed(2), "");
}

// A fall gains the energy that gravity puts in. In advance, the watch allows only a fall by the
// body's own size.
TEST(EnergyWatch, LeavesAFallAlone) {
  SimulatedCase fall(flying, {"world.gravity=[0, 0, -9.81]", "time.duration=1"});
  EnergyWatch watch(fall.dynamics(), fall.integrator().state());
  const std::vector<double> y = fall.advance_to(1);
  EXPECT_FALSE(watch.check(1, y, fall.dynamics().energies(1, y)));
  EXPECT_GT(watch.largest_share(), 0.8);
}

// A run whose energy is watched.
class WatchedCase {
 public:
  explicit WatchedCase(const std::string& text, const Overrides& overrides = {})
      : run_(text, overrides),
        watch_(run_.dynamics(), run_.integrator().state()),
        start_(free_energy(run_.dynamics().energies(0, run_.integrator().state()))) {}

  // Steps until `time` or until a failure, which it returns.
  std::string advance_to(double time) {
    Integrator& integrator = run_.integrator();
    while (integrator.time() < time) {
      if (const auto failure = integrator.step()) return failure->text;
      const double now = integrator.time();
      const Energies energies = run_.dynamics().energies(now, integrator.state());
      if (const auto reason = watch_.check(now, integrator.state(), energies)) return reason->text;
      gain_ = free_energy(energies) - start_;
      most_gain_ = std::max(most_gain_, std::abs(gain_));
    }
    return "";
  }
  std::span<const double> state() { return run_.integrator().state(); }
  double gain() const { return gain_; }  // J, of the free particles and of contact
  double most_gain() const { return most_gain_; }
  const ExternalWork& external() const { return watch_.external(); }

 private:
  double free_energy(const Energies& energies) const {
    return energies.total() - external().held_kinetic_energy() -
           external().held_gravitational_energy();
  }

  SimulatedCase run_;
  EnergyWatch watch_;
  double start_ = 0, gain_ = 0, most_gain_ = 0;
};

// Undamped springs, pulled and rotated at one end.
constexpr const char* pulled = R"(
[time]
duration = 1
position_tolerance = 1e-7
relative_tolerance = 1e-6
[contact]
enabled = false
[material.spring]
density = 1
membrane = "springs"
structural_stiffness = 100
[[body]]
name = "rod"
shape = { type = "rectangle", size = [1.0, 0.5], resolution = [3, 5] }
[[body.pin]]
edges = ["first_col"]
[[body.pin]]
edges = ["last_col"]
motion = { keyframes = [{ time = 0.5, translation = [0.3, 0, 0.2], rotation_deg = [0, 40, 0] }] }
)";

TEST(ExternalWork, OfPinsIsWhatTheFreeParticlesGain) {
  WatchedCase rod(pulled);
  EXPECT_EQ(rod.advance_to(0.45), "");
  EXPECT_GT(rod.gain(), 1);
  EXPECT_NEAR(rod.external().work(), rod.gain(), 0.005 * rod.gain());
  EXPECT_LT(rod.external().doubt(), 0.1 * rod.gain());
}

// The pull is so slow that damping takes almost nothing.
TEST(ExternalWork, OfASlowPullIsTheEnergyOfTheSpring) {
  WatchedCase rod(R"(
[time]
duration = 20
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.spring]
density = 0.01
membrane = "springs"
structural_stiffness = 100
shear_stiffness = 0
mass_damping = 10
[[body]]
name = "rod"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [2, 3] }
[[body.pin]]
edges = ["first_col"]
[[body.pin]]
edges = ["last_col"]
motion = { keyframes = [{ time = 10, translation = [0.1, 0, 0] }] }
)");
  EXPECT_EQ(rod.advance_to(11), "");
  EXPECT_NEAR(rod.external().work(), rod.gain(), 0.01 * rod.gain());
  EXPECT_GT(rod.gain(), 0.1);
}

// Two sheets that seams pull together. Single corrections make them overshoot within a step, so
// that the springs push at its end.
TEST(ExternalWork, OfSeamsThatOvershootIsDoubted) {
  constexpr const char* sheets = R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
density = 0.25
membrane_stiffness = 400
bending_stiffness = 1e-5
stiffness_damping = 2e-3
[[body]]
name = "front"
position = [0, 0, 0.13]
shape = { type = "rectangle", size = [0.5, 0.3], resolution = [7, 11] }
[[body]]
name = "back"
position = [0, 0, -0.13]
shape = { type = "rectangle", size = [0.5, 0.3], resolution = [6, 9] }
[[seam]]
body = "front"
edge = "first_col"
to = "back"
to_edge = "first_col"
closing_time = 1
[[seam]]
body = "front"
edge = "last_col"
to = "back"
to_edge = "last_col"
closing_time = 1
)";
  WatchedCase exact(sheets, method("cvode"));
  EXPECT_EQ(exact.advance_to(1.2), "");
  for (const double step : {0.033, 0.0166666, 0.008, 0.002}) {
    WatchedCase by_one(sheets, method("euler", {key("step", step), "time.newton=1"}));
    EXPECT_EQ(by_one.advance_to(1.2), "") << step;
    EXPECT_LT(by_one.gain(), by_one.external().work() + by_one.external().doubt()) << step;
    EXPECT_LT(by_one.external().doubt(), 1.5 * exact.external().work()) << step;
  }
}

// A carriage that lowers a sheet takes its weight's energy, by single corrections too: that leaves
// no room for a gain.
TEST(ExternalWork, OfATieThatLowersASheetIsNotDoubted) {
  constexpr const char* lowered = R"(
[contact]
enabled = false
[material.cloth]
density = 0.25
membrane_stiffness = 400
stiffness_damping = 2e-3
mass_damping = 2
[[body]]
name = "sheet"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[obstacle]]
name = "carriage"
position = [0, 0, 0.3]
shape = { type = "rectangle", size = [0.5, 0.1], resolution = [3, 3] }
motion = { velocity = [0, 0, -0.5] }
[[tie]]
body = "sheet"
edges = ["last_row"]
to = "carriage"
stiffness = 1000
)";
  const double lost = 0.25 * 0.09 * 9.81 * 0.5;
  WatchedCase run(lowered, method("euler", {key("step", 0.01), "time.newton=1"}));
  EXPECT_EQ(run.advance_to(1), "");
  EXPECT_NEAR(run.external().work(), -lost, 0.2 * lost);
  EXPECT_LT(run.external().doubt(), 0.1 * lost);
}

// A small sheet that hangs from a corner and swings, undamped.
constexpr const char* swinging = R"(
[time]
duration = 4
[contact]
enabled = false
[material.cotton]
density = 0.34
membrane_stiffness = 490
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
[[body.pin]]
corners = ["first_first"]
)";

// Returns the Newton iterations of `count` steps.
std::int64_t newton_iterations(Integrator& integrator, int count) {
  const std::int64_t before = integrator.counts().newton_iterations;
  for (int i = 0; i < count; ++i) EXPECT_FALSE(integrator.step());
  return integrator.counts().newton_iterations - before;
}

// After a gain, cvode solves the equations of a hundred steps more exactly.
TEST(EnergyWatch, TightensNewtonsIterationForAWhile) {
  SimulatedCase plain(swinging), tight(swinging);
  newton_iterations(plain.integrator(), 400);
  newton_iterations(tight.integrator(), 400);
  tight.integrator().tighten();
  const auto during = newton_iterations(tight.integrator(), 100);
  EXPECT_GT(during, 1.2 * static_cast<double>(newton_iterations(plain.integrator(), 100)));
  EXPECT_LT(newton_iterations(tight.integrator(), 100), 0.9 * static_cast<double>(during));
}

// By loose tolerances the sheet gains energy while it falls. A simulation then makes steps more
// exact, whatever its frames are.
TEST(EnergyWatch, GainsTightenTheMethodWhateverTheFramesAre) {
  const Overrides loose{key("position_tolerance", 5e-4)};
  WatchedCase alone(swinging, loose);
  EXPECT_NE(alone.advance_to(0.4), "");
  std::vector<std::vector<Vec3>> ends;
  for (const char* frames : {"time.frames_per_second=10", "time.frames_per_second=700"}) {
    Simulation sim = make_simulation(parse_case(swinging, "test.toml", {loose.front(), frames}));
    SimulatedCase method_alone(swinging, loose);
    bool is_same = true;
    while (sim.time() < 0.4 && !sim.step()) {
      ASSERT_FALSE(method_alone.integrator().step());
      is_same = is_same && sim.time() == method_alone.integrator().time();
    }
    EXPECT_FALSE(is_same) << frames;
    ends.push_back(sim.position("sheet"));
  }
  EXPECT_EQ(ends[0], ends[1]);
}

// Steps of given length are not short after a jump: the power at their start must be the one after
// it.
TEST(ExternalWork, OfWindThatJumpsIsWhatASheetGains) {
  for (const Overrides& options : {method("cvode", {"time.position_tolerance=1e-7"}),
                                   method("implicit_midpoint", {"time.step=1e-3"})}) {
    Overrides overrides = options;
    for (const char* each :
         {"world.wind={ times = [0, 0.1, 0.2], values = [[0, 0, 0], [0, 0, 4], "
          "[0, 0, -2]], between = \"step\" }",
          "material.default.normal_drag=1.2", "material.default.density=0.1", "time.duration=0.5"})
      overrides.emplace_back(each);
    WatchedCase sheet(flying, overrides);
    for (const double time : {0.15, 0.21, 0.4}) {
      EXPECT_EQ(sheet.advance_to(time), "");
      EXPECT_NEAR(sheet.external().work(), sheet.gain(), 0.01 * sheet.most_gain()) << time;
    }
    EXPECT_LT(sheet.external().doubt(), 0.3 * sheet.most_gain());
    EXPECT_GT(sheet.most_gain(), 3e-3);
  }
}

// Energy counts the potential of the present gravity, so that it is not kept where gravity varies:
// what it gains is the work that the watch adds. The sheet starts far from the origin, which must
// not matter.
TEST(ExternalWork, OfGravityThatVariesIsWhatTheEnergyGains) {
  for (const char* gravity :
       {"world.gravity={ times = [0, 0.1, 0.3], values = [[0, 0, 0], [3, 0, -20], [0, 0, 10]] }",
        "world.gravity={ times = [0, 0.1, 0.3], values = [[0, 0, 5], [3, 0, -20], [0, 0, 10]], "
        "between = \"step\" }",
        "world.gravity={ times = [0, 0.3], values = [[0, 0, 5], [3, 0, -20]], between = "
        "\"smooth\" }"}) {
    for (const char* pin :
         {"title=free",
          "body.sheet.pin=[{corners=[\"first_first\"], motion={velocity=[1, 0, 0]}}]"}) {
      WatchedCase sheet(flying, {gravity, pin, "body.sheet.position=[5, -3, 40]",
                                 "time.duration=0.5", "time.position_tolerance=1e-7"});
      EXPECT_EQ(sheet.advance_to(0.4), "") << gravity << pin;
      const double work = sheet.external().work();
      // The potential changes by joules, the motion by hundredths of them.
      EXPECT_GT(sheet.most_gain(), 1) << gravity << pin;
      EXPECT_NEAR(work, sheet.gain(), 1e-4) << gravity << pin;
      EXPECT_LT(sheet.external().doubt(), 1e-3) << gravity << pin;
    }
  }
}

// The height of a fall is bounded by gravity so far, not by gravity that is still to come.
TEST(EnergyWatch, FindsAGainBesideGravityThatVaries) {
  for (const bool gains : {false, true}) {
    SimulatedCase run(flying, {"world.gravity={ times = [0, 0.05, 1], values = [[0, 0, 0], [0, 0, "
                               "-1], [0, 0, -1000]] }",
                               "time.duration=1"});
    EnergyWatch watch(run.dynamics(), run.integrator().state());
    std::vector<double> y;
    while (run.integrator().time() < 0.04) {
      ASSERT_FALSE(run.integrator().step());
      const double now = run.integrator().time();
      y.assign(run.integrator().state().begin(), run.integrator().state().end());
      if (gains && now >= 0.04) {
        for (std::size_t i = y.size() / 2; i < y.size(); ++i) y[i] *= 1.2;
      }
      const auto failure = watch.check(now, y, run.dynamics().energies(now, y));
      EXPECT_EQ(failure.has_value(), gains && now >= 0.04) << now;
      // Gravity is 20 t so far.
      EXPECT_NEAR(watch.external().largest_gravity(), 20 * now, 1e-9);
      EXPECT_NEAR(watch.external().fall_speed(), 10 * now * now, 1e-9);
    }
  }
}

TEST(ExternalWork, OfWindIsWhatASheetGains) {
  WatchedCase sheet(flying, {"world.wind=[0, 0, 5]", "material.default.normal_drag=1.2",
                             "material.default.density=0.1", "time.duration=0.5",
                             "time.position_tolerance=1e-7"});
  EXPECT_EQ(sheet.advance_to(0.4), "");
  EXPECT_GT(sheet.gain(), 1e-3);
  EXPECT_NEAR(sheet.external().work(), sheet.gain(), 0.01 * sheet.gain());
}

// A sheet struck by a moving plate and thrown ahead of it.
constexpr const char* struck = R"(
[time]
duration = 0.2
position_tolerance = 1e-7
[world]
gravity = [0, 0, 0]
[contact]
damping_time = 0
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [4, 4] }
position = [0, 0, -0.01]
motion = { velocity = [0, 0, 0.2] }
)";

TEST(ExternalWork, OfAPlateIsWhatTheSheetGains) {
  WatchedCase sheet(struck);
  EXPECT_EQ(sheet.advance_to(0.1), "");
  EXPECT_GT(sheet.gain(), 1e-5);
  EXPECT_NEAR(sheet.external().work(), sheet.gain(), 0.02 * sheet.gain());
}

// The watch evaluates forces but changes no bit.
TEST(EnergyWatch, ChangesNothing) {
  for (const Overrides& options : {method("cvode"), method("arkode"), method("euler"),
                                   method("euler", {"time.step=2e-3", "time.newton=1"})}) {
    WatchedCase watched(struck, options);
    EXPECT_EQ(watched.advance_to(0.1), "");
    SimulatedCase alone(struck, options);
    while (alone.integrator().time() < 0.1) ASSERT_FALSE(alone.integrator().step());
    EXPECT_TRUE(std::ranges::equal(watched.state(), alone.integrator().state())) << options.front();
  }
}

constexpr const char* small_flag = R"(
[time]
duration = 0.5
[world]
wind = [6.0, 0.8, 0.0]
[contact]
enabled = false
[material.nylon]
density = 0.15
membrane_stiffness = 1500
bending_stiffness = 5e-5
stiffness_damping = 1e-3
bending_damping = 1e-3
normal_drag = 1.2
tangential_drag = 0.05
[[body]]
name = "flag"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [1.5, 1.0], resolution = [13, 19] }
[[body.pin]]
edges = ["first_col"]
)";

TEST(EnergyWatch, HoldsInWind) {
  WatchedCase fine(small_flag);
  EXPECT_EQ(fine.advance_to(0.5), "");
  EXPECT_GT(fine.external().work(), 0.1);
  WatchedCase burst(small_flag,
                    {"time.position_tolerance=3e-2", "body.flag.shape.resolution=[33, 49]"});
  EXPECT_NE(burst.advance_to(0.5).find("the motion has gained energy"), std::string::npos);
}

}  // namespace
}  // namespace weft::sim::energy_watch_test
