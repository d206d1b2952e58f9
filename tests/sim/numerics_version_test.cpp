// Results may move only together with the number of the numerics, by which sweeps know old results.
#include "sim/run/numerics_version.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/motion/dynamics.h"
#include "sim/run/make_simulation.h"

namespace weft::sim::numerics_version_test {
namespace {

// A sheet with a pin, bending, drag and friction falls on a ball, which it meets at 0.01 s.
constexpr const char* scene = R"(
[contact]
friction = 0.3
[material.cloth]
density = 0.2
membrane_stiffness = 300
bending_stiffness = 1e-5
stiffness_damping = 1e-3
normal_drag = 1.0
[[body]]
name = "sheet"
position = [0.01, 0.02, 0.061]
velocity = [0.1, 0, -1]
shape = { type = "rectangle", size = [0.12, 0.1], resolution = [7, 9] }
[[body.pin]]
corners = ["first_first"]
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.05, resolution = [9] }
)";

// Spheres fall on a tilted sheet and on each other: 0.3 s, in which each of them collides.
constexpr const char* spheres = R"(
[time]
method = "impulses"
[compute]
threads = 1
[[particles]]
name = "balls"
radius = 0.02
restitution = 0.3
friction = 0.4
positions = { type = "grid", count = [2, 2, 3], jitter = 0.001, centre = [0, 0, 0.15] }
[[obstacle]]
name = "floor"
rotation_deg = [10, 0, 0]
shape = { type = "plane", size = [2, 2] }
)";

struct Stored {
  std::string method, friction;
  double time;                  // s
  std::vector<Vec3> positions;  // m, of the last vertex and of the one in the middle, at that time
  double tolerance = 0;  // m; larger where products in single precision decide on convergence
};

// Adaptive steps of high accuracy are sensitive: rounding errors, which differ from processor to
// processor, grow to 1e-6 m until 0.05 s, and sooner with friction. Those methods run without it,
// for a shorter time.
//
// If a change moves the values on purpose, increase numerics_version, and store those that this
// test prints.
constexpr int stored_version = 25;
const std::vector<Stored> stored{
    {"cvode",
     "0",
     0.015,
     {{0.068771879845, 0.067317810303, 0.045262172608},
      {0.008684270479, 0.018038450143, 0.048968057577}},
     1e-5},
    {"euler",
     "0.3",
     0.05,
     {{0.055434562384, 0.043875053009, 0.001456558598},
      {0.007555817232, 0.019998327574, 0.049988927704}},
     1e-9},
    {"arkode",
     "0",
     0.015,
     {{0.068776769360, 0.067320786974, 0.045262506395},
      {0.008690673706, 0.018042670203, 0.048962982161}},
     3e-5},
};

std::vector<Vec3> last_and_middle(std::span<const Vec3> positions) {
  return {positions.back(), positions[positions.size() / 2]};
}

void expect_stored(const std::string& what, const std::vector<Vec3>& now,
                   const std::vector<Vec3>& before, double tolerance) {
  for (std::size_t i = 0; i < now.size(); ++i) {
    EXPECT_LT((now[i] - before[i]).norm(), tolerance)
        << what << ": results have moved; see sim/run/numerics_version.h. Now: " << [&] {
             char text[128];
             std::snprintf(text, sizeof text, "{%.12f, %.12f, %.12f}", now[i].x(), now[i].y(),
                           now[i].z());
             return std::string(text);
           }();
  }
}

TEST(NumericsVersion, NumberChangesWithTheNumerics) {
  ASSERT_EQ(numerics_version, stored_version) << "store the values of the new numerics below";
  for (const Stored& each : stored) {
    auto simulation = make_simulation(parse_case(
        scene, "case.toml",
        {"time.method=" + each.method, "contact.friction=" + each.friction, "compute.threads=1"}));
    const auto failure = simulation.advance(each.time);
    ASSERT_FALSE(failure) << failure->text;
    expect_stored(each.method, last_and_middle(simulation.position("sheet")), each.positions,
                  each.tolerance);
  }
  // Sweeps over impulses are in single precision, so that processors differ by more.
  auto simulation = make_simulation(parse_case(spheres, "case.toml"));
  const auto failure = simulation.advance(0.3);
  ASSERT_FALSE(failure) << failure->text;
  expect_stored("impulses", last_and_middle(StateView::of(simulation.state()).position),
                {{0.019497113360, 0.055069968638, 0.033095119280},
                 {-0.024419625567, 0.004974116347, 0.023633504427}},
                1e-5);
}

}  // namespace
}  // namespace weft::sim::numerics_version_test
