// Runs that need some steps shorter than minimum_step.
#include "sim/integrator/short_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <tuple>

#include "sim/run/make_simulation.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::short_steps_test {
namespace {

// A sheet of 4 g at rest over a plate, with a gap (m) within a range of 2 mm.
std::string sheet_over_plate(double gap) {
  char text[512];
  std::snprintf(text, sizeof text, R"(
[contact]
range = 2e-3
[material.cloth]
density = 0.2
membrane_stiffness = 1000
bending_stiffness = 1e-4
stiffness_damping = 1e-3
bending_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, %.9f]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [9, 9] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
)",
                1e-3 + gap);
  return text;
}

double mean_height(const std::vector<Vec3>& positions) {
  double sum = 0;
  for (int i = 0; i < 81; ++i) sum += positions[i].z();
  return sum / 81;
}

// The first steps are shorter than minimum_step. Without them, no run with these gaps starts.
TEST(ShortSteps, SurfacesThatStartCloseAreFollowed) {
  constexpr double time = 5e-3;  // s
  for (const double gap : {3e-4, 1e-4, 1e-5}) {
    SimulatedCase fine(sheet_over_plate(gap), method("implicit_midpoint", {key("step", 2e-6)}));
    const double height = mean_height(fine.positions_at(time));
    EXPECT_GT(height, 1e-3 + gap + 7e-4);
    for (const char* name : {"cvode", "arkode"}) {
      SimulatedCase sheet(sheet_over_plate(gap), method(name));
      EXPECT_NEAR(mean_height(sheet.positions_at(time)), height, 5e-5) << name << ' ' << gap;
    }
  }
}

// A quarter of the mass is at each corner, which a pin holds over the plate until 0.05 s.
TEST(ShortSteps, SurfacesThatPinsReleaseAreFollowed) {
  const std::string pins =
      "\n[[body.pin]]\nedges = [\"first_row\", \"last_row\"]\nrelease_time = 0.05\n";
  std::string text = sheet_over_plate(1e-4);
  text.replace(text.find("[9, 9]"), 6, "[2, 2]").insert(text.find("[[obstacle]]"), pins);
  for (const char* name : {"cvode", "arkode"}) {
    auto simulation = make_simulation(parse_case(text, "test.toml", method(name)));
    while (simulation.time() < 0.06) {
      const auto failure = simulation.step();
      ASSERT_FALSE(failure) << name << ": " << failure->text;
      const double height = StateView::of(simulation.state()).position[0].z();
      if (simulation.time() <= 0.05) {
        ASSERT_EQ(height, 1.1e-3) << name;
      } else if (simulation.time() > 0.055) {
        ASSERT_GT(height, 2e-3) << name;
      }
    }
  }
}

TEST(ShortSteps, AStateThatIsSetIsFollowed) {
  for (const char* name : {"cvode", "arkode"}) {
    SimulatedCase sheet(sheet_over_plate(0.02), method(name));
    const std::vector<double> above = sheet.advance_to(0.01);
    const double now = sheet.integrator().time();
    std::vector<double> state(above.size());  // at rest
    for (int i = 0; i < 81; ++i) {
      state[3 * i] = above[3 * i];
      state[3 * i + 1] = above[3 * i + 1];
      state[3 * i + 2] = 1.1e-3;
    }
    sheet.integrator().restart(now, state);
    EXPECT_GT(mean_height(sheet.positions_at(now + 5e-3)), 2e-3) << name;
  }
}

// Beads fall onto a plate and pass through the range in less than a tenth of a millisecond. The
// second bead is of the size of a grain of sand.
TEST(ShortSteps, ImpactsInAThinRangeAreFollowed) {
  for (const auto& [radius, range, height] : {std::tuple(3e-3, 2e-4, 0.3), {3e-4, 4e-5, 0.016}}) {
    char text[512];
    std::snprintf(text, sizeof text, R"(
[time]
position_tolerance = %g
[contact]
range = %g
[[particles]]
name = "bead"
radius = %g
density = 2500
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, %g] }
[[obstacle]]
name = "plate"
shape = { type = "plane", size = [0.2, 0.2] }
)",
                  range / 200, range, radius, height);
    for (const char* name : {"cvode", "arkode"}) {
      SimulatedCase bead(text, method(name));
      const double fall = std::sqrt(2 * (height - radius) / 9.81);
      EXPECT_GT(bead.positions_at(1.2 * fall)[0].z(), radius + range) << name << ' ' << radius;
    }
  }
}

TEST(ShortSteps, AFailureNamesTheShortestOneThatWasTried) {
  for (const char* name : {"cvode", "arkode"}) {
    SimulatedCase sheet(sheet_over_plate(1e-7), method(name));
    const auto failure = sheet.integrator().step();
    ASSERT_TRUE(failure) << name;
    EXPECT_EQ(failure->kind, Failure::Kind::surfaces) << name;
    EXPECT_EQ(
        failure->text.find("no step down to 1e-10 s (a thousandth of time.minimum_step) keeps "
                           "the surfaces apart at t = 0 s: "),
        0U)
        << failure->text;
  }
}

// The waves of an undamped sheet need steps of less than a millisecond again and again.
TEST(ShortSteps, AreFew) {
  for (const char* name : {"cvode", "arkode"}) {
    SimulatedCase sheet(hanging_sheet, method(name, {"time.minimum_step=1e-2"}));
    std::optional<Failure> failure;
    int steps = 0;
    for (; !failure && steps < 1000; ++steps) failure = sheet.integrator().step();
    ASSERT_TRUE(failure) << name;
    EXPECT_NE(failure->text.find("step down to 0.01 s (time.minimum_step)"), std::string::npos)
        << failure->text;
    EXPECT_GT(steps, 100) << name;
    EXPECT_LT(steps, 150) << name;
  }
}

TEST(ShortSteps, AreAHundredMoreThanOthers) {
  TimeCase time;
  time.minimum_step = 1e-6;
  ShortSteps steps(time);
  for (int i = 0; i < 200; ++i) steps.note(1e-6);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(steps.shortest(), 1e-9) << i;
    steps.note(0.99e-6);
  }
  EXPECT_EQ(steps.shortest(), 1e-6);
  steps.note(0.99e-6);
  EXPECT_FALSE(steps.are_allowed());
  steps.note(1e-6);
  EXPECT_EQ(steps.shortest(), 1e-9);
  steps.note(0.99e-6);
  EXPECT_EQ(steps.shortest(), 1e-6);
}

}  // namespace
}  // namespace weft::sim::short_steps_test
