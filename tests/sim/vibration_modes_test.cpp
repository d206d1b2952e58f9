// Natural modes against closed forms and tables.
#include <omp.h>

#include <array>
#include <cmath>
#include <numbers>

#include "../reference_value.h"
#include "mode_case.h"

namespace weft::sim::vibration_modes_test {
namespace {

using Kind = VibrationMode::Kind;

// Angular frequencies of the first modes of a plate: numbers omega a^2 sqrt(rho h / D).
struct PlateTable {
  const char* edges;
  int rigid;
};
class SquarePlate : public testing::TestWithParam<PlateTable> {};
TEST_P(SquarePlate, HasTheFrequenciesOfTheTable) {
  const auto& [edges, rigid] = GetParam();
  const VibrationModes found =
      modes_of(benchmark_case(std::string("plate_modes_") + edges), rigid + 6);
  ASSERT_EQ(std::ssize(found.modes), rigid + 6);
  for (int i = 0; i < rigid; ++i) EXPECT_EQ(found.modes[i].kind, Kind::rigid) << i;
  for (int i = 0; i < 6; ++i) {
    const VibrationMode& mode = found.modes[rigid + i];
    const double exact =
        reference_value("square_plate_" + std::string(edges) + "_" + std::to_string(i + 1));
    EXPECT_EQ(mode.kind, Kind::vibration);
    EXPECT_NEAR(mode.angular_frequency(), exact, 5e-4 * exact) << edges << ' ' << i + 1;
    EXPECT_LT(mode.error, 1e-12);
  }
}
INSTANTIATE_TEST_SUITE_P(All, SquarePlate,
                         testing::Values(PlateTable{"ssss", 0}, PlateTable{"cccc", 0},
                                         PlateTable{"cscs", 0}, PlateTable{"ffff", 6}),
                         [](const auto& test) { return test.param.edges; });

// The error of cubic splines falls with the fourth power of the spacing.
TEST(SquarePlate, ConvergesWithOrderFour) {
  const double exact = 2 * std::pow(std::numbers::pi, 2);
  std::array<double, 2> error{};
  for (int i = 0; i < 2; ++i) {
    const int points = i == 0 ? 7 : 11;  // 4 and 8 elements
    const std::string size = std::to_string(points);
    const VibrationModes found =
        modes_of(benchmark_case("plate_modes_ssss",
                                {"body.plate.shape.resolution=[" + size + ", " + size + "]"}),
                 1);
    error[i] = std::abs(found.modes[0].angular_frequency() - exact);
  }
  EXPECT_GT(error[0] / error[1], 12);
}

// Small vibrations of bending that has yielded are elastic: the frequencies under the load that
// bent the strip are those after it has lost a thousandth.
TEST(YieldedStrip, HasTheFrequenciesOfItsElasticBending) {
  const auto frequencies_at = [](const std::string& duration) {
    const Case source = parse_case(R"(
[time]
method = "static"
frames_per_second = 10
[static]
loading = "in_time"
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.metal]
density = 0.5
membrane_stiffness = 2000
bending_stiffness = 1e-3
yield_curvature = 6
hardening = 0.3
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.2, 0.05], resolution = [17, 5] }
[[body.pin]]
edges = ["first_row"]
clamp = true
[[load]]
body = "strip"
type = "area"
force = { times = [0, 1, 2], values = [[0, 0, 0], [0, 0, -4.9], [0, 0, -4.895]] }
)",
                                   "strip.toml", {"time.duration=" + duration});
    return modes_of(source, 4).modes;
  };
  const auto bent = frequencies_at("1"), unloaded = frequencies_at("2");
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(bent[i].angular_frequency(), unloaded[i].angular_frequency(),
                1e-3 * unloaded[i].angular_frequency());
  }
}

// Out of its plane, a membrane of triangles is the lattice of five points with lumped masses.
double lattice_frequency(int m, int n) {
  constexpr int cells = 32;
  const double s = 1000 / 0.7 * (1.05 * 1.05 - 1) / 2;
  const auto part = [](int waves) {
    return std::pow(std::sin(waves * std::numbers::pi / (2 * cells)), 2);
  };
  return std::sqrt(4 * s / 0.2 * cells * cells * (part(m) + part(n)));
}

TEST(Membrane, HasTheFrequenciesOfADrumWithTheirMultiplicity) {
  const VibrationModes found = modes_of(benchmark_case("membrane_modes"), 12);
  const std::array<std::array<int, 2>, 12> waves{{{1, 1},
                                                  {1, 2},
                                                  {2, 1},
                                                  {2, 2},
                                                  {1, 3},
                                                  {3, 1},
                                                  {2, 3},
                                                  {3, 2},
                                                  {1, 4},
                                                  {4, 1},
                                                  {3, 3},
                                                  {2, 4}}};
  for (std::size_t i = 0; i < waves.size(); ++i) {
    const auto [m, n] = waves[i];
    const double lattice = lattice_frequency(m, n);
    EXPECT_NEAR(found.modes[i].angular_frequency(), lattice, 1e-9 * lattice) << m << ' ' << n;
    const double drum =
        std::sqrt(1000 / 0.7 * (1.05 * 1.05 - 1) / 2 / 0.2) * std::numbers::pi * std::hypot(m, n);
    EXPECT_NEAR(lattice, drum, 0.01 * drum);
  }
}

TEST(Modes, AreOrthogonalAlsoWithinAnEigenspace) {
  const VibrationModes found = modes_of(benchmark_case("membrane_modes"), 6);
  for (std::size_t i = 0; i < found.modes.size(); ++i) {
    EXPECT_GT(found.modes[i].modal_mass, 0);
    for (std::size_t j = 0; j < i; ++j) {
      double product = 0;  // masses of inner vertices are equal
      for (std::size_t p = 0; p < found.modes[i].shape.size(); ++p)
        product += found.modes[i].shape[p].dot(found.modes[j].shape[p]);
      EXPECT_NEAR(product, 0, 1e-8 * 33 * 33) << i << ' ' << j;
    }
  }
}

// Both columns of vertices swing by themselves. The lower corners are too light and too heavy by a
// sixth of the mass of a vertex above, which parts each pair by the first power of the spacing. The
// mean of the pair has an error of second order, so that two spacings give the limit.
TEST(HangingChain, SwingsAtTheFrequenciesOfBernoulli) {
  const VibrationModes coarse = modes_of(benchmark_case("hanging_chain"), 6);
  const VibrationModes fine =
      modes_of(benchmark_case("hanging_chain", {"body.strip.shape.resolution=[129, 2]"}), 6);
  const auto mean = [](const VibrationModes& found, int pair) {
    return 0.5 * (found.modes[2 * pair].angular_frequency() +
                  found.modes[2 * pair + 1].angular_frequency());
  };
  for (int i = 0; i < 6; ++i) {
    const double zero = reference_value("bessel_J0_zero_" + std::to_string(i / 2 + 1));
    const double exact = zero / 2 * std::sqrt(9.81);
    EXPECT_NEAR(fine.modes[i].angular_frequency(), exact, 2e-3 * exact) << i;
    const double limit = (4 * mean(fine, i / 2) - mean(coarse, i / 2)) / 3;
    EXPECT_NEAR(limit, exact, 5e-5 * exact) << i;
  }
}

TEST(Beam, VibratesAtTheFrequenciesOfACantilever) {
  const VibrationModes found = modes_of(benchmark_case("beam_modes"), 3);
  for (int i = 0; i < 3; ++i) {
    const double root = reference_value("cantilever_beam_root_" + std::to_string(i + 1));
    const double exact = root * root * std::sqrt(1e-3);
    EXPECT_NEAR(found.modes[i].angular_frequency(), exact, 2e-4 * exact) << i;
  }
}

TEST(Beam, IsFreeAfterSixRigidMotions) {
  Case source = benchmark_case("beam_modes");
  source.body[0].pin.clear();
  const VibrationModes found = modes_of(source, 8);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(found.modes[i].kind, Kind::rigid) << i;
  for (int i = 0; i < 2; ++i) {
    const double root = reference_value("free_beam_root_" + std::to_string(i + 1));
    const double exact = root * root * std::sqrt(1e-3);
    EXPECT_NEAR(found.modes[6 + i].angular_frequency(), exact, 3e-4 * exact) << i;
  }
}

// A pendulum: one free vertex, or rather a stiff triangle of them, has few coordinates: all modes
// are found when more are asked for.
constexpr const char* pendulum = R"(
[contact]
enabled = false
[material.bar]
density = 1
membrane_stiffness = 1e6
[[body]]
name = "bar"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
[[body.pin]]
edges = ["last_row"]
)";

TEST(Modes, AreAllFoundWhereThereAreFew) {
  const VibrationModes found = modes_of(parse_case(pendulum, "test.toml"), 50);
  EXPECT_EQ(found.unknowns, 6);
  ASSERT_EQ(found.modes.size(), 6U);
  // Out of the plane, both free corners swing under their own weight, as mathematical pendulums
  // with the length of the stretched side.
  for (int i = 0; i < 2; ++i)
    EXPECT_NEAR(found.modes[i].angular_frequency(), std::sqrt(9.81), 1e-4 * std::sqrt(9.81));
}

TEST(Modes, GrowAboutAnUnstableEquilibrium) {
  const VibrationModes found =
      modes_of(parse_case(pendulum, "test.toml", {"world.gravity=[0, 0, 9.81]"}), 3);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(found.modes[i].kind, Kind::growth);
    EXPECT_NEAR(found.modes[i].growth_rate(), std::sqrt(9.81), 1e-3 * std::sqrt(9.81));
    EXPECT_EQ(found.modes[i].frequency(), 0);
  }
  EXPECT_EQ(found.modes[2].kind, Kind::vibration);
}

TEST(Modes, OfClothWithoutTensionAreSlack) {
  const VibrationModes found = modes_of(
      benchmark_case("membrane_modes",
                     {"body.membrane.stretch=[1, 1, 1]", "body.membrane.shape.resolution=[5, 5]"}),
      9);
  for (const VibrationMode& mode : found.modes) EXPECT_EQ(mode.kind, Kind::slack);
  // The start shape of the pendulum is not stretched yet. Stiff modes come next to its slack ones.
  const VibrationModes start = modes_of(parse_case(pendulum, "test.toml"), 3, true);
  EXPECT_EQ(start.modes[0].kind, Kind::slack);
  EXPECT_EQ(start.modes[1].kind, Kind::slack);
  EXPECT_EQ(start.modes[2].kind, Kind::vibration);
}

// Four vertices of a sheet lie on a plate and can only rise. Each has the stiffness b'' of the
// barrier times its area: omega^2 = b'' / density, where b' = density gravity in equilibrium.
TEST(Modes, HaveSpringsForContacts) {
  const std::string resting = R"(
[material.cloth]
density = 0.2
[[body]]
name = "sheet"
position = [0.003, 0.002, 0.0016]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [2, 2] }
[[body.pin]]
rows = [0, -1]
axes = ["x", "y"]
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
)";
  struct Rest {
    double height, eigenvalue;
  };
  const auto rest = [&](double gravity) {
    CaseEquilibrium about(parse_case(resting, "test.toml",
                                     {"world.gravity=[0, 0, " + std::to_string(-gravity) + "]",
                                      "contact.friction=0.3", "time.position_tolerance=1e-9"}),
                          {});
    if (const auto failure = about.find()) ADD_FAILURE() << failure->text;
    const auto found = find_vibration_modes(about.dynamics(), about.time(), about.state(), 4);
    for (const VibrationMode& mode : found.modes)
      EXPECT_NEAR(mode.eigenvalue, found.modes[0].eigenvalue, 1e-6 * found.modes[0].eigenvalue);
    return Rest{StateView::of(about.state()).position[0].z(), found.modes[0].eigenvalue};
  };
  const Rest lower = rest(9.91), middle = rest(9.81), upper = rest(9.71);
  const double slope = (9.91 - 9.71) / (upper.height - lower.height);
  EXPECT_NEAR(middle.eigenvalue, slope, 1e-3 * slope);
}

TEST(Modes, HaveTheSameBitsForAnyNumberOfThreads) {
  std::vector<VibrationModes> found;
  for (const int threads : {1, 3}) {
    omp_set_num_threads(threads);
    found.push_back(modes_of(
        benchmark_case("plate_modes_ffff", {"compute.threads=" + std::to_string(threads)}), 12));
  }
  omp_set_num_threads(omp_get_num_procs());
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(found[0].modes[i].eigenvalue, found[1].modes[i].eigenvalue);
    EXPECT_EQ(found[0].modes[i].shape, found[1].modes[i].shape);
  }
}

// Far from the origin, rounded positions stretch a sheet. The tension of this strain neither holds
// slack cloth nor makes it unstable.
TEST(Modes, OfSlackClothAreSlackEverywhere) {
  const std::string text = R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 0.5], resolution = [5, 6] }
pin = [{ edges = ["first_col", "last_col"] }]
)";
  for (const char* position : {"[0, 0, 0]", "[1, 0, 0]", "[1000, 3, 20]"}) {
    const VibrationModes found = modes_of(
        parse_case(text, "test.toml", {std::string("body.sheet.position=") + position}), 10);
    for (const VibrationMode& mode : found.modes) EXPECT_EQ(mode.kind, Kind::slack) << position;
  }
}

// Rigid motions of a thin shell have no frequency anywhere; its vibrations keep theirs.
TEST(Modes, OfAThinShellAreTheSameEverywhere) {
  const std::string text = R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.sheet]
model = "shell"
youngs_modulus = 1e9
poisson_ratio = 0.3
shell_thickness = 1e-4
volume_density = 1000
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 0.5], resolution = [15, 21] }
)";
  const double frequency = modes_of(parse_case(text, "test.toml"), 7).modes[6].frequency();
  for (const char* position : {"[1, 0, 0]", "[100, 30, 20]", "[1000, 30, 20]"}) {
    const VibrationModes found = modes_of(
        parse_case(text, "test.toml", {std::string("body.sheet.position=") + position}), 7);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(found.modes[i].kind, Kind::rigid) << position << i;
    EXPECT_EQ(found.modes[6].kind, Kind::vibration) << position;
    EXPECT_NEAR(found.modes[6].frequency(), frequency, 1e-2 * frequency) << position;
  }
}

TEST(Modes, GrowAboutAnUnstableEquilibriumFarAway) {
  const VibrationModes found =
      modes_of(parse_case(pendulum, "test.toml",
                          {"world.gravity=[0, 0, 9.81]", "body.bar.position=[1000, 300, 20]"}),
               3);
  EXPECT_EQ(found.modes[0].kind, Kind::growth);
  EXPECT_NEAR(found.modes[0].growth_rate(), std::sqrt(9.81), 1e-4 * std::sqrt(9.81));
}

}  // namespace
}  // namespace weft::sim::vibration_modes_test
