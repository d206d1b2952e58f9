// Paths of equilibria that cannot go on, that are saved, and that prescribed motions lead.
#include <cmath>
#include <fstream>
#include <sstream>

#include "channel_run.h"
#include "joint_cases.h"
#include "sim/run/recorded_run.h"
#include "sim/trajectory/trajectory.h"
#include "tests/temporary_folder.h"

namespace weft::sim::load_path_test {
namespace {

std::string benchmark_text(const std::string& name) {
  std::stringstream text;
  text << std::ifstream(std::string(WEFT_CASES_DIR) + "/benchmarks/" + name + ".toml").rdbuf();
  return text.str();
}

std::optional<Failure> run_to_its_end(Simulation& simulation, double time) {
  while (simulation.time() < time && !simulation.has_ended()) {
    if (auto failure = simulation.step()) return failure;
  }
  return std::nullopt;
}

// The roof of cases/benchmarks/hinged_roof_arc_length.toml, whose load grows in time to its full
// size.
std::string roof_under_growing_load(const std::string& at_limit_point) {
  std::string text = benchmark_text("hinged_roof_arc_length");
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("duration = 100, frames_per_second = 1", "duration = 1, frames_per_second = 20");
  const auto first = text.find("static = {"), last = text.find('\n', first);
  text.replace(first, last - first,
               "static = { loading = \"in_time\", at_limit_point = \"" + at_limit_point + "\" }");
  replace("force = [-750, 0, 0]", "force = { times = [0, 1], values = [[0, 0, 0], [-750, 0, 0]] }");
  return text;
}
constexpr int centre = 8 * 9;

TEST(LoadPath, EndsAtALimitPointWithTheLastGoodLoad) {
  Simulation roof = simulation_of(roof_under_growing_load("stop"));
  const double start = roof.position("roof")[centre].x();
  const auto failure = run_to_its_end(roof, 1);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::newton);
  EXPECT_NE(
      failure->text.find("the tangent stiffness has a negative direction there, as at a limit "
                         "point; the forces are farthest from balance at body \"roof\""),
      std::string::npos)
      << failure->text;
  EXPECT_NE(failure->text.find("static.loading = \"arc_length\""), std::string::npos);
  // The limit is at 0.741. The last load is within the shortest part of a frame below it.
  EXPECT_GT(roof.time(), 0.735);
  EXPECT_LT(roof.time(), 0.745);
  EXPECT_EQ(failure->time, roof.time());
  const double deflection = start - roof.position("roof")[centre].x();
  EXPECT_GT(deflection, 9.5);
  EXPECT_LT(deflection, 11.5);
}

// The file ends with the last equilibrium, and with the reason.
TEST(LoadPath, RecordsTheLastGoodLoadAndTheReason) {
  const TemporaryFolder folder;
  RunOptions options;
  options.trajectory = folder.path("roof.h5");
  const auto scene = build_scene(parse_case(roof_under_growing_load("stop"), "test.toml"));
  const RunReport report = run_simulation(*scene, options);
  EXPECT_EQ(report.status, RunReport::Status::failed);
  const TrajectoryReader reader(options.trajectory);
  const int last = reader.frames() - 1;
  EXPECT_GT(reader.time(last), 0.735);
  EXPECT_LT(reader.time(last), 0.745);
  EXPECT_EQ(reader.series_values("negative_directions").back(), 0);
  const double way = reader.positions(0, 0)[centre].x() - reader.positions(0, last)[centre].x();
  EXPECT_GT(way, 9.5);
  EXPECT_LT(way, 11.5);
  EXPECT_EQ(reader.end()->reason, report.reason);
  EXPECT_NE(report.reason.find("as at a limit point"), std::string::npos) << report.reason;
}

TEST(LoadPath, JumpsBeyondALimitPointIfAsked) {
  Simulation roof = simulation_of(roof_under_growing_load("jump"));
  const double start = roof.position("roof")[centre].x();
  const auto failure = run_to_its_end(roof, 1);
  ASSERT_FALSE(failure) << failure->text;
  // The path by arc length has this deflection at the full load.
  EXPECT_NEAR(start - roof.position("roof")[centre].x(), 28.6, 0.3);
  EXPECT_EQ(roof.integrator().path_point()->negative_directions, 0);
}

// The step after a jump is not extrapolated from the step that jumped: it takes about as many
// iterations as the later ones.
TEST(LoadPath, ForgetsTheWayToAJump) {
  Simulation roof = simulation_of(roof_under_growing_load("jump"));
  const auto iterations = [&] { return roof.counts().newton_iterations; };
  double deflection = roof.position("roof")[centre].x();
  std::vector<std::int64_t> after;
  while (roof.time() < 1 && after.size() < 3) {
    const std::int64_t before = iterations();
    ASSERT_FALSE(roof.step());
    if (!after.empty()) after.push_back(iterations() - before);
    const double now = roof.position("roof")[centre].x();
    if (after.empty() && deflection - now > 10) after.push_back(0);
    deflection = now;
  }
  ASSERT_EQ(after.size(), 3U);
  EXPECT_LE(after[1], after[2] + 2);
}

// The load factor of the first point, as the tangent at the start predicts it. The roof softens
// from the start, so the point lies a little below.
TEST(LoadPath, BeginsWithTheFirstLoadFactor) {
  double last = 0;
  for (const double factor : {0.02, 0.05, 0.1}) {
    Simulation roof = simulation_of(benchmark_text("hinged_roof_arc_length"),
                                    {"static.first_load_factor=" + std::to_string(factor)});
    ASSERT_FALSE(roof.step());
    const double reached = roof.integrator().path_point()->load_factor;
    EXPECT_LT(reached, factor);
    EXPECT_NEAR(reached, factor, 0.15 * factor);
    EXPECT_GT(reached, last);
    last = reached;
  }
}

// The path ends with the first point at which a vertex is displaced as far.
TEST(LoadPath, EndsAtTheLargestDisplacement) {
  constexpr double farthest = 6;  // mm
  Simulation roof =
      simulation_of(benchmark_text("hinged_roof_arc_length"), {"static.largest_displacement=6"});
  const std::vector<Vec3> start = roof.position("roof");
  const auto displacement = [&] {
    const std::vector<Vec3> now = roof.position("roof");
    double largest = 0;
    for (std::size_t i = 0; i < now.size(); ++i)
      largest = std::max(largest, (now[i] - start[i]).norm());
    return largest;
  };
  double before = 0, last = 0;
  while (!roof.has_ended()) {
    ASSERT_FALSE(roof.step());
    before = last;
    last = displacement();
  }
  EXPECT_LT(before, farthest);
  EXPECT_GE(last, farthest);
  EXPECT_LT(roof.integrator().path_point()->load_factor, 1);
}

std::string loaded_plate(const std::string& pins, const std::string& more = "") {
  return R"(
[time]
method = "static"
duration = 1
frames_per_second = 4
[static]
loading = "in_time"
[world]
gravity = [0, 0, 0]
[material.plate]
model = "shell"
youngs_modulus = 1e7
poisson_ratio = 0.3
shell_thickness = 0.01
volume_density = 1000
[[body]]
name = "plate"
shape = { type = "rectangle", size = [1, 1], resolution = [4, 4] }
)" + pins +
         R"(
[[load]]
body = "plate"
corners = ["last_last"]
force = { times = [0, 1], values = [[0, 0, 0], [0, 0, 0.05]] }
)" + more;
}
const std::string hinge = "pin = [{ edges = [\"first_col\"] }]\n";
const std::string without_contact = "[contact]\nenabled = false\n";

// Without enough supports the tangent is singular.
TEST(LoadPath, NamesWhereAFreeBodyIsWeakest) {
  for (const std::string& pins : {std::string(), hinge}) {
    Simulation plate = simulation_of(without_contact + loaded_plate(pins));
    const auto failure = run_to_its_end(plate, 1);
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, Failure::Kind::newton);
    EXPECT_EQ(failure->text.find("no equilibrium is found beyond the load at t = 0 s: the tangent "
                                 "stiffness is singular; it is weakest at body \"plate\", row "),
              0U)
        << failure->text;
    for (const Vec3& each : plate.position("plate")) EXPECT_TRUE(each.allFinite());
  }
}

TEST(LoadPath, ByArcLengthBeginsAtNoMechanism) {
  std::string text = without_contact + loaded_plate(hinge);
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("\"in_time\"", "\"arc_length\"");
  replace("force = { times = [0, 1], values = [[0, 0, 0], [0, 0, 0.05]] }", "force = [0, 0, 1]");
  Simulation plate = simulation_of(text);
  const auto failure = run_to_its_end(plate, 1);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::newton);
  EXPECT_EQ(failure->text.find("no path of equilibria begins at the unloaded shape"), 0U)
      << failure->text;
}

// A clamp that would carry the plate through an obstacle ends the run before they touch.
TEST(LoadPath, EndsWhereSurfacesStandInTheWay) {
  Simulation plate = simulation_of(
      loaded_plate("pin = [{ edges = [\"first_col\"], clamp = true, motion = { velocity = [0, 0, "
                   "-0.2] } }]\n",
                   "[[obstacle]]\nname = \"floor\"\nposition = [0, 0, -0.1]\nshape = { type = "
                   "\"rectangle\", size = [3, 3], resolution = [4, 4] }\n"));
  const auto failure = run_to_its_end(plate, 1);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::surfaces) << failure->text;
  EXPECT_GT(plate.time(), 0.3);
  EXPECT_LT(plate.time(), 0.5);
  for (const Vec3& each : plate.position("plate")) EXPECT_GT(each.z(), -0.1);
}

class SavedPath : public testing::TestWithParam<std::string> {
 protected:
  static std::string text() {
    return GetParam() == "in_time" ? roof_under_growing_load("stop")
                                   : benchmark_text("hinged_roof_arc_length");
  }
};
INSTANTIATE_TEST_SUITE_P(All, SavedPath, testing::Values("in_time", "arc_length"));

TEST_P(SavedPath, ContinuesWithTheSameBits) {
  Simulation first = simulation_of(text());
  for (int step = 0; step < 4; ++step) ASSERT_FALSE(first.step());
  const std::string bytes = first.save();
  Simulation second = simulation_of(text());
  second.restore(bytes);
  EXPECT_EQ(second.integrator().path_point()->load_factor,
            first.integrator().path_point()->load_factor);
  for (int step = 0; step < 4; ++step) {
    ASSERT_FALSE(first.step());
    ASSERT_FALSE(second.step());
  }
  EXPECT_EQ(first.time(), second.time());
  EXPECT_EQ(first.position("roof"), second.position("roof"));
  EXPECT_EQ(second.integrator().path_point()->load_factor,
            first.integrator().path_point()->load_factor);
}

TEST_P(SavedPath, HasTheSameBitsForAnyNumberOfThreads) {
  Simulation one = simulation_of(text(), {"compute.threads=1"});
  Simulation three = simulation_of(text(), {"compute.threads=3"});
  for (int step = 0; step < 6; ++step) {
    ASSERT_FALSE(one.step());
    ASSERT_FALSE(three.step());
  }
  EXPECT_EQ(one.position("roof"), three.position("roof"));
}

// A clamp that turns and moves bends a strip to an arc. Its moment is E I times the curvature.
TEST(PrescribedRotation, BendsAStripToAnArc) {
  constexpr double angle = 1.2, length = 1, width = 0.1;
  const double radius = length / angle;
  const auto number = [](double value) { return std::to_string(value); };
  const std::string text = R"(
[time]
method = "static"
duration = 1
frames_per_second = 8
position_tolerance = 1e-8
[static]
loading = "in_time"
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[output]
channels = ["reactions"]
[material.strip]
model = "shell"
youngs_modulus = 1e9
poisson_ratio = 0
shell_thickness = 0.01
volume_density = 1000
[[body]]
name = "strip"
shape = { type = "rectangle", size = [1, 0.1], resolution = [4, 27] }
pin = [
  { edges = ["first_col"], clamp = true },
  { edges = ["last_col"], clamp = true, motion = { centre = [0.5, 0, 0], keyframes = [{ time = 1, translation = [)" +
                           number(radius * std::sin(angle) - length) + ", 0, " +
                           number(radius * (1 - std::cos(angle))) + "], rotation_deg = [0, " +
                           number(-angle * 180 / std::acos(-1.0)) + R"(, 0] }] } },
]
)";
  ChannelRun run(text);
  run.advance_to(1);
  const double rigidity = 1e9 * width * 1e-6 / 12;
  for (const int column : {9, 13, 17}) {
    // The control points of the middle rows lie off the arc by a part of a cell.
    const Vec3 x = run.position()[27 + column];
    const double from_centre = std::hypot(x.x() + 0.5, x.z() - radius);
    EXPECT_NEAR(from_centre, radius, 1e-3) << column;
  }
  EXPECT_NEAR(run.simulation().energies().total(), 0.5 * rigidity * angle * angle / length,
              2e-3 * 0.5 * rigidity * angle * angle / length);
  EXPECT_NEAR(std::abs(run.vector("reactions/strip/pin_2/moment").y()), rigidity * angle / length,
              0.01 * rigidity * angle / length);
}

}  // namespace
}  // namespace weft::sim::load_path_test
