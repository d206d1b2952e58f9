// Pins that move through obstacles or other pins are detected, and the run ends before they cross.
#include "sim/motion/prescribed_paths.h"

#include <gtest/gtest.h>

#include "tests/sim/sampled_scene.h"

namespace weft::sim::prescribed_paths_test {
namespace {

// A motion about the centre of the sheet: 90 degrees in a second.
const std::string quarter_turn = "{ centre = [0, 0, 0], angular_velocity_deg = [0, 0, 90] }";

// Runs to the end or a failure, which is returned.
std::string failure_of(SimulatedCase& sim, double until) {
  while (sim.integrator().time() < until) {
    if (auto failure = sim.integrator().step()) return failure->text;
    const double time = sim.integrator().time();
    const std::span<const double> y = sim.integrator().state();
    const int crossed = crossings(sim.scene(), sim.positions(time, {y.begin(), y.end()}));
    if (crossed > 0) return "crosses at " + std::to_string(time);
  }
  return "";
}

TEST(PrescribedPaths, PinsThatWouldPassThroughAnObstacleEndTheRun) {
  for (const Overrides& by : {method("cvode"), method("arkode"), method("euler"),
                              method("euler", {"time.step=0.1"}), method("static")}) {
    SCOPED_TRACE(by.front());
    SimulatedCase sim(pins_against_a_plate, by);
    const std::string failure = failure_of(sim, 1);
    EXPECT_TRUE(failure.starts_with("prescribed motions leave no room")) << failure;
    EXPECT_NE(failure.find("obstacle \"plate\""), std::string::npos) << failure;
    // The leading corners are 0.4 m from the plate.
    EXPECT_NEAR(sim.integrator().time(), 0.4, 1e-3);
  }
}

TEST(PrescribedPaths, AnObstacleThatWouldPassThroughPinsEndsTheRun) {
  SimulatedCase sim(
      std::string(pins_against_a_plate) + "motion = { velocity = [-1, 0, 0] }\n",
      {"body.0.pin.0.motion.velocity=[0, 0, 0]", "body.0.pin.1.motion.velocity=[0, 0, 0]"});
  const std::string failure = failure_of(sim, 1);
  EXPECT_TRUE(failure.starts_with("prescribed motions leave no room")) << failure;
  EXPECT_NEAR(sim.integrator().time(), 0.4, 1e-3);
}

// A plate reaches two pinned corners, which it meets in steps of many lengths.
TEST(PrescribedPaths, NoSpeedOfAnObstacleLeadsThroughPins) {
  constexpr const char* text = R"(
[material.cloth]
density = 0.2
membrane_stiffness = 250
bending_stiffness = 6e-4
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0.06, -0.1, 0.004]
shape = { type = "rectangle", size = [0.8, 1.0], resolution = [7, 5] }
[[body.pin]]
corners = ["first_first", "last_last"]
[[obstacle]]
name = "plate"
shape = { type = "plane", size = [8, 8] }
[obstacle.motion]
velocity = [0, 0, 0.3]
)";
  for (const char* name : {"cvode", "arkode", "euler"}) {
    for (const double thickness : {0.0, 0.001, 0.003}) {
      for (const double speed : {0.1, 0.2, 0.3, 0.4, 0.8, 1.5}) {
        SimulatedCase sim(text, {"time.method=\"" + std::string(name) + "\"",
                                 "body.0.thickness=" + std::to_string(thickness),
                                 "obstacle.0.thickness=" + std::to_string(thickness),
                                 "obstacle.0.motion.velocity.2=" + std::to_string(speed)});
        const std::string failure = failure_of(sim, 0.06);
        EXPECT_TRUE(failure.starts_with("prescribed motions leave no room"))
            << name << ' ' << thickness << ' ' << speed << ": " << failure;
        EXPECT_NEAR(sim.integrator().time(), 0.004 / speed, 1e-4);
      }
    }
  }
}

// One edge moves over the other and is pulled through it at 0.45 s.
TEST(PrescribedPaths, PinsThatPassThroughPinsAreFound) {
  SimulatedCase sim(R"(
[time]
duration = 0.6
[world]
gravity = [0, 0, 0]
[material.cloth]
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[body.pin]]
edges = ["first_row"]
[[body.pin]]
edges = ["last_row"]
[body.pin.motion]
keyframes = [
  { time = 0 },
  { time = 0.3, translation = [0.03, -0.2, 0.05], rotation_deg = [0, 0, 10] },
  { time = 0.6, translation = [0.03, -0.2, -0.05], rotation_deg = [0, 0, 10] },
]
)");
  PrescribedPaths paths(sim.scene());
  EXPECT_FALSE(paths.find_crossing(0.3, 0.35));
  EXPECT_FALSE(paths.find_crossing(0.44, 0.449));
  EXPECT_TRUE(paths.find_crossing(0.449, 0.451));
  EXPECT_FALSE(paths.find_crossing(0.451, 0.46));
}

// A row rotates by a quarter turn; a small plate lies between the arc of a corner and its chord.
TEST(PrescribedPaths, PathsOfPinsAreArcs) {
  const auto found = [](const std::string& plate, double until) {
    const SampledScene scenes(
        pins_against_a_plate,
        {R"(body.sheet.pin=[{ edges = ["first_row"], motion = )" + quarter_turn +
             "}, { rows = [2, 2], cols = [2, 2] }]",
         "obstacle.plate.position=" + plate, "obstacle.plate.rotation_deg=[90, 0, 0]",
         "obstacle.plate.shape.size=[0.006, 0.02]", "obstacle.plate.shape.resolution=[2, 2]"},
        refined_surface);
    const bool is_found = PrescribedPaths(scenes.plain()).find_crossing(0, until).has_value();
    // Points between the particles follow the same arcs.
    EXPECT_EQ(PrescribedPaths(scenes.scene()).find_crossing(0, until).has_value(), is_found);
    return is_found;
  };
  EXPECT_TRUE(found("[0.13, 0, 0]", 1));
  EXPECT_FALSE(found("[0.13, 0, 0]", 0.3));
  // Neighbours on the row stray from their chords by more than their distance, but together.
  EXPECT_FALSE(found("[0.13, 0, 1]", 1));
}

// Pins and a plate beside them rotate together without crossing.
TEST(PrescribedPaths, PinsMayBeCarriedBesideAnObstacle) {
  SimulatedCase sim(std::string(pins_against_a_plate) + "motion = " + quarter_turn + "\n",
                    {"obstacle.plate.position=[0.101, 0, 0]", "body.0.pin.0.motion=" + quarter_turn,
                     "body.0.pin.1.motion=" + quarter_turn, "body.0.thickness=1e-4",
                     "obstacle.plate.thickness=1e-4"});
  EXPECT_EQ(failure_of(sim, 0.1), "");
}

}  // namespace
}  // namespace weft::sim::prescribed_paths_test
