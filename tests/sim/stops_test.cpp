// Stops of long steps: which pairs of features get one (docs/theory.md, section 2).
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/contact/contact.h"
#include "sim/scene/scene.h"

namespace weft::sim::stops_test {
namespace {

// A single quad above a large plate. Its path is many slacks long.
const std::string quad_above_plate = R"(
[time]
duration = 1
[contact]
range = 0.002
[[body]]
name = "quad"
thickness = 0.002
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [2, 2] }
[[obstacle]]
name = "plate"
thickness = 0.002
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
)";

// Returns the number of stops for a quad that comes from 0.3 m above the plate, along a straight
// path, to an end with a gap (m).
int stops_at(double gap) {
  const auto scene = build_scene(parse_case(quad_above_plate, "quad.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  std::vector<Vec3> start = scene->initial_position, end = start;
  const std::vector<Vec3> velocity(start.size(), Vec3(0, 0, -20));
  for (int i = 0; i < scene->dynamic_particles; ++i) {
    start[i].z() = 0.3;
    end[i].z() = 0.002 + gap;
  }
  const std::vector<Mat3> diagonal(scene->dynamic_particles, Mat3::Identity());
  EXPECT_FALSE(contact.evaluate(start, velocity, 1));
  int added = 0;
  const StepPath path{PlacedParticles(start), PlacedParticles(end), {}, 0.015};
  EXPECT_FALSE(contact.add_stops(path, 0.015, velocity, diagonal, &added));
  return added;
}

// All four corners would pass through the plate, or end closer to it than a fifth of the range.
TEST(Stops, HoldPairsThatWouldMeetOrEndTooNear) {
  EXPECT_EQ(stops_at(-0.2), 4);
  EXPECT_EQ(stops_at(-1e-4), 4);
  EXPECT_EQ(stops_at(3.9e-4), 4);
  EXPECT_EQ(stops_at(4.1e-4), 0);
  EXPECT_EQ(stops_at(0.1), 0);
}

}  // namespace
}  // namespace weft::sim::stops_test
