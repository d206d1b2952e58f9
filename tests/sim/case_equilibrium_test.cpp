// The states about which modes are computed.
#include <cmath>

#include "mode_case.h"

namespace weft::sim::case_equilibrium_test {
namespace {

constexpr const char* released = R"(
[contact]
enabled = false
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[[body.pin]]
edges = ["last_row"]
release_time = 0.5
)";

// A weight pulls the membrane down: it is stiffer about its equilibrium than about its start.
TEST(CaseEquilibrium, IsThatUnderTheLoads) {
  const Case source = benchmark_case(
      "membrane_modes", {"world.gravity=[0, 0, -100]", "body.membrane.shape.resolution=[9, 9]"});
  CaseEquilibrium about(source, {});
  ASSERT_FALSE(about.find());
  EXPECT_LT(about.imbalance(), 1e-6);
  CaseEquilibrium start(source, {.start_shape = true, .load_factor = {}, .progress = {}});
  ASSERT_FALSE(start.find());
  EXPECT_GT(start.imbalance(), 0.01);
  EXPECT_GT(modes_of(source, 1).modes[0].frequency(),
            1.02 * modes_of(source, 1, true).modes[0].frequency());
}

// Pins and loads act as at the end of the run: the frequency of a string grows with the root of its
// tension.
TEST(CaseEquilibrium, HasThePinsAndLoadsOfTheEnd) {
  const std::string moving = R"(
[time]
duration = 2
frames_per_second = 2
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.skin]
poisson_ratio = 0
[[body]]
name = "membrane"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 17] }
stretch = [1.01, 1, 1]
[[body.pin]]
edges = ["first_col"]
[[body.pin]]
edges = ["last_col"]
motion = { velocity = [0.015, 0, 0] }
[[body.pin]]
rows = [0, -1]
axes = ["y"]
)";
  const double ratio = modes_of(parse_case(moving, "test.toml"), 1).modes[0].frequency() /
                       modes_of(parse_case(moving, "test.toml"), 1, true).modes[0].frequency();
  const auto tension = [](double stretch) { return stretch * stretch - 1; };
  EXPECT_NEAR(ratio, std::sqrt(tension(1.04) / tension(1.01)), 1e-6);
}

TEST(CaseEquilibrium, FailsWithTheReason) {
  // Nothing balances a weight on a free body.
  CaseEquilibrium falling(
      benchmark_case("plate_modes_ffff",
                     {"world.gravity=[0, 0, -1]", "body.plate.shape.resolution=[5, 5]"}),
      {});
  const auto failure = falling.find();
  ASSERT_TRUE(failure);
  EXPECT_NE(failure->text.find("singular"), std::string::npos) << failure->text;
}

// Squares of such forces overflow: a comparison of infinities would take the start for balanced.
TEST(CaseEquilibrium, EnormousLoadsAreNotBalanced) {
  const std::string shell = R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.metal]
model = "shell"
youngs_modulus = 7e10
shell_thickness = 0.002
volume_density = 2700
[[body]]
name = "plate"
shape = { type = "rectangle", size = [0.5, 0.1], resolution = [5, 9] }
pin = [{ edges = ["first_col"], clamp = true }]
[[load]]
body = "plate"
type = "line"
edges = ["last_col"]
force = [0, 0, 1e160]
)";
  CaseEquilibrium about(parse_case(shell, "test.toml"), {});
  EXPECT_TRUE(about.find());
}

// A free shell is at rest anywhere. A tiny pressure on a held one is a force nevertheless.
TEST(CaseEquilibrium, TellsRoundingFromForces) {
  const std::string shell = R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.film]
model = "shell"
youngs_modulus = 1e6
poisson_ratio = 0
shell_thickness = 1e-3
volume_density = 1000
[[body]]
name = "film"
shape = { type = "rectangle", size = [1, 0.5], resolution = [5, 6] }
)";
  for (const char* position : {"[1, 0, 0]", "[10000, 30, 20]", "[1e6, 3e5, 7]"}) {
    CaseEquilibrium about(
        parse_case(shell, "test.toml", {std::string("body.film.position=") + position}), {});
    const auto failure = about.find();
    EXPECT_FALSE(failure) << position << ": " << failure->text;
  }
  const std::string pressed = shell + R"(pin = [{ edges = ["first_col"], clamp = true }]
[[load]]
body = "film"
type = "pressure"
pressure = 1e-8
)";
  CaseEquilibrium about(parse_case(pressed, "test.toml"), {});
  ASSERT_FALSE(about.find());
  EXPECT_GT(StateView::of(about.state()).position.back().z(), 1e-6);
}

TEST(CaseEquilibrium, RefusesPinsThatLetGo) {
  const Case source = parse_case(std::string(released), "test.toml");
  try {
    CaseEquilibrium about(source, {});
    FAIL();
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(),
                 "test.toml:8:1: a pin that takes hold or lets go in time has no part in modes\n"
                 "  expected a pin that always holds");
  }
}

}  // namespace
}  // namespace weft::sim::case_equilibrium_test
