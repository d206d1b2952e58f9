// A varied case is the same case in another place: all distances, and the motion, are the same.
#include "tests/robustness/varied_case.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/case/case_reader.h"
#include "sim/run/make_simulation.h"
#include "sim/scene/scene.h"

namespace weft::robustness::varied_case_test {
namespace {

using sim::Vec3;

sim::Case flag() {
  return sim::parse_case(R"(
[time]
duration = 0.05
[world]
wind = { times = [0, 1], values = [[1, 2, 0], [3, 0, 1]] }
[contact]
enabled = false
[material.cloth]
normal_drag = 1
[[body]]
name = "flag"
position = [0.3, 0.2, 0.1]
rotation_deg = [20, 30, 40]
velocity = [0.5, 0, 1]
angular_velocity_deg = [0, 100, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 5] }
[[body.pin]]
edges = ["first_row"]
[body.pin.motion]
keyframes = [ { time = 0 }, { time = 0.05, translation = [0.02, 0, 0.01], rotation_deg = [0, 20, 5] } ]
[[obstacle]]
name = "ball"
position = [0, 0, -1]
rotation_deg = [0, 200, 0]
shape = { type = "sphere", radius = 0.3, resolution = [4] }
)",
                         "flag.toml");
}

std::vector<Vec3> all_points(const sim::Case& source, double end) {
  sim::Simulation simulation = sim::make_simulation(source);
  if (const auto failure = simulation.advance(end)) ADD_FAILURE() << failure->text;
  std::vector<Vec3> points = simulation.position("flag");
  for (const Vec3& point : simulation.position("ball")) points.push_back(point);
  return points;
}

// Distances between all points of body and obstacle do not depend on the orientation.
void expect_same_distances(const std::vector<Vec3>& a, const std::vector<Vec3>& b, double error) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      ASSERT_NEAR((a[i] - a[j]).norm(), (b[i] - b[j]).norm(), error) << i << " " << j;
}

TEST(VariedCase, IsTheSameSceneInAnotherPlace) {
  const sim::Case source = flag();
  const std::vector<Vec3> before = all_points(source, 0.05);
  for (const std::uint32_t seed : {0U, 1U, 2U}) {
    const std::vector<Vec3> after = all_points(varied(source, seed), 0.05);
    // Errors of integration differ with the orientation, because tolerances hold by component.
    expect_same_distances(before, after, 2e-4);
    EXPECT_GT((before[0] - after[0]).norm(), 0.01);  // it is elsewhere
  }
}

TEST(VariedCase, SeedsDiffer) {
  const sim::Case source = flag();
  const Vec3 first = varied(source, 3).body[0].position;
  EXPECT_EQ(first, varied(source, 3).body[0].position);
  EXPECT_GT((first - varied(source, 4).body[0].position).norm(), 1e-3);
  EXPECT_NEAR(first.norm(), source.body[0].position.norm(), 1e-5);
}

TEST(VariedCase, DirectionsThatCannotTurnAreRefused) {
  sim::Case source = flag();
  source.body[0].pin[0].axes = {"x"};
  EXPECT_THROW(varied(source, 1), std::invalid_argument);
}

}  // namespace
}  // namespace weft::robustness::varied_case_test
