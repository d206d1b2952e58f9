// Energies as a file records them, against closed forms.
#include <cmath>
#include <numbers>

#include "sim/run/recorded_run.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::recorded_energies_test {
namespace {

// Runs a case and returns the values of a series from its file. All series of energies add up to
// energy_total.
std::vector<double> recorded(const std::string& text, const std::string& series) {
  const TemporaryFolder folder;
  RunOptions options;
  options.trajectory = folder.path("run.h5");
  const auto scene = build_scene(parse_case("[contact]\nenabled = false\n" + text, "test.toml"));
  const RunReport report = run_simulation(*scene, options);
  EXPECT_EQ(report.status, RunReport::Status::done) << report.reason;
  const TrajectoryReader reader(options.trajectory);
  const std::vector<double> total = reader.series_values("energy_total");
  std::vector<double> sum(total.size(), 0.0);
  for (const auto& each : reader.series()) {
    if (!each.name.starts_with("energy_") || each.name == "energy_total") continue;
    EXPECT_EQ(each.units, "J") << each.name;
    const std::vector<double> values = reader.series_values(each.name);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += values[i];
  }
  for (std::size_t i = 0; i < sum.size(); ++i)
    EXPECT_NEAR(sum[i], total[i], 1e-12 + 1e-9 * std::abs(total[i]));
  return reader.series_values(series);
}

// An equilibrium under a weight of 10 m/s^2.
constexpr const char* hanging = R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
position_tolerance = 1e-8
[world]
gravity = [0, 0, -10]
[material.cloth]
density = 0.2
membrane_stiffness = 500
poisson_ratio = 0
)";

}  // namespace

// A plate that starts bent to a cylinder has the energy D A / (2 R^2).
TEST(RecordedEnergies, OfAShell) {
  const auto values = recorded(R"(
[time]
duration = 1e-4
frames_per_second = 1e4
[world]
gravity = [0, 0, 0]
[material.plate]
model = "shell"
youngs_modulus = 1e7
poisson_ratio = 0.3
shell_thickness = 1e-3
volume_density = 1000
[[body]]
name = "plate"
start = { bend_radius = 0.5 }
shape = { type = "rectangle", size = [0.3, 0.2], resolution = [9, 25] }
)",
                               "energy_shell");
  const double exact = 1e7 * 1e-9 / (12 * (1 - 0.09)) * 0.3 * 0.2 / (2 * 0.5 * 0.5);
  ASSERT_EQ(values.size(), 2U);
  EXPECT_NEAR(values[0], exact, 0.01 * exact);
  EXPECT_LE(values[1], values[0]);
}

// A piece of the weight W hangs by a seam of the length l and the stiffness K, which opens by W /
// (K l) and stores W^2 / (2 K l).
TEST(RecordedEnergies, OfASeam) {
  const auto values = recorded(std::string(hanging) + R"(
[[body]]
name = "held"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
pin = [{ rows = [0, -1], cols = [0, -1], axes = ["x", "y"] }, { edges = ["last_row"] }]
[[body]]
name = "hung"
rotation_deg = [90, 0, 0]
position = [0, 0, -0.2]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
pin = [{ rows = [0, -1], cols = [0, -1], axes = ["x", "y"] }]
[[seam]]
body = "hung"
edge = "last_row"
to = "held"
to_edge = "first_row"
stiffness = 1e3
)",
                               "energy_seams");
  const double weight = 0.2 * 0.2 * 0.2 * 10;
  const double exact = weight * weight / (2 * 1e3 * 0.2);
  ASSERT_EQ(values.size(), 2U);
  EXPECT_LT(values[0], 1e-20);
  EXPECT_NEAR(values[1], exact, 0.02 * exact);
}

// Two pieces that start folded at their seam by an angle t store D L t^2 / (2 a) in the triangles
// of the width a on both sides of the seam of the length L, if Poisson's ratio is 0.
TEST(RecordedEnergies, OfBendingAcrossASeam) {
  const double angle = std::numbers::pi / 6;
  const auto number = [](double value) { return std::to_string(value * 1e6) + "e-6"; };
  const auto values = recorded(R"(
[time]
duration = 1e-4
frames_per_second = 1e4
[world]
gravity = [0, 0, 0]
[material.cloth]
density = 0.2
membrane_stiffness = 500
poisson_ratio = 0
bending_stiffness = 1e-3
[[body]]
name = "near"
position = [-0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[body]]
name = "far"
rotation_deg = [0, -30, 0]
position = [)" + number(0.05 * std::cos(angle)) +
                                   ", 0, " + number(0.05 * std::sin(angle)) + R"(]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[seam]]
body = "near"
edge = "last_col"
to = "far"
to_edge = "first_col"
)",
                               "energy_seam_bending");
  const double exact = 1e-3 * 0.05 * angle * angle / (2 * 0.1 / 8);
  ASSERT_EQ(values.size(), 2U);
  EXPECT_NEAR(values[0], exact, 1e-6 * exact);
}

// A sheet of two columns hangs by springs of the stiffness k at its upper corners. Each carries
// half of the weight W, and both together store W^2 / (4 k). In an equilibrium k is 1e5 times the
// membrane's stiffness.
TEST(RecordedEnergies, OfASupport) {
  const auto values = recorded(std::string(hanging) + R"(
[[body]]
name = "sheet"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.2], resolution = [5, 2] }
pin = [
  { edges = ["last_row"], axes = ["z"] },
  { corners = ["last_first"], axes = ["x"] },
  { rows = [0, -1], cols = [0, -1], axes = ["y"] },
]
)",
                               "energy_support");
  const double weight = 0.2 * 0.1 * 0.2 * 10;
  const double exact = weight * weight / (4 * 1e5 * 500);
  ASSERT_EQ(values.size(), 2U);
  EXPECT_NEAR(values[1], exact, 1e-3 * exact);
}

}  // namespace weft::sim::recorded_energies_test
