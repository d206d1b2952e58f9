// Limits of principal stretches: held by every method, reported when nothing can hold them.
#include <cmath>

#include "bench/cloth_runs.h"
#include "sim/base/failure.h"
#include "sim/case/case_error.h"
#include "sim/run/initial_state.h"
#include "tests/sim/bad_case.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::strain_limit_test {
namespace {

// A soft sheet that hangs by two corners under ten times its weight: without a limit it would
// stretch by a third.
constexpr const char* heavy_sheet = R"(
[time]
duration = 0.15
frames_per_second = 60
[world]
gravity = [0, 0, -98.1]
[contact]
enabled = false
[material.soft]
density = 0.2
membrane_stiffness = 100
bending_stiffness = 1e-5
stiffness_damping = 1e-3
strain_limit = 0.05
[[body]]
name = "sheet"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [9, 9] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";

double strain_of(Simulation& simulation, std::span<const double> y, double time) {
  std::vector<Vec3> position, velocity;
  simulation.dynamics().expand_all(time, y, position, velocity);
  return bench::largest_strain(simulation.scene(), position);
}

struct Method {
  std::string name;
  Overrides more;
};
const std::vector<Method> all_methods = {{"cvode", {}},
                                         {"arkode", {}},
                                         {"euler", {"time.step=0.005"}},
                                         {"euler", {"time.step=0.005", "time.newton=1"}},
                                         {"euler", {"time.position_tolerance=1e-4"}},
                                         {"implicit_midpoint", {"time.step=0.001"}},
                                         {"verlet", {}},
                                         {"static", {"time.frames_per_second=30"}}};

// Two edges are drawn apart by a tenth of the sheet: no state keeps within the limit.
constexpr const char* drawn_sheet = R"(
[time]
duration = 0.2
frames_per_second = 50
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.soft]
density = 0.2
membrane_stiffness = 100
stiffness_damping = 1e-3
strain_limit = 0.05
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [5, 5] }
[[body.pin]]
edges = ["first_col"]
[[body.pin]]
edges = ["last_col"]
motion = { keyframes = [{ time = 0.2, translation = [0.05, 0, 0] }] }
)";

}  // namespace

// At the ends of all steps, and in their middle.
TEST(StrainLimit, HoldsUnderTenTimesTheWeightByEveryMethod) {
  for (const auto& [name, more] : all_methods) {
    SCOPED_TRACE(name + (more.empty() ? "" : ", " + more.back()));
    const auto [at_ends, within] = bench::largest_strains(
        read_case(WEFT_CASES_DIR "/benchmarks/strain_limit.toml", method(name, more)));
    EXPECT_LT(at_ends, 0.05);
    EXPECT_LT(within, 0.05);
    EXPECT_GT(at_ends, 0.04);  // it was put to the test
  }
}

TEST(StrainLimit, WithoutItTheSheetStretchesFurther) {
  std::string text = heavy_sheet;
  text.erase(text.find("strain_limit"), std::string("strain_limit = 0.05\n").size());
  Simulation simulation = simulation_of(text, method("static", {"time.frames_per_second=30"}));
  advance_to(simulation, 0.15);
  EXPECT_GT(strain_of(simulation, simulation.state(), 0.15), 0.3);
  const std::vector<std::string> names = simulation.dynamics().force_names();
  EXPECT_EQ(std::ranges::count(names, "strain_limit"), 0);
}

// In equilibrium the same limit gives the same shape, whatever the method that led there. The plane
// sheet is compressed across the pull. A sheet that hangs by two corners, or bends as easily as the
// others here, buckles to either side and has several equilibria. This one stays plane.
TEST(StrainLimit, EquilibriaAgree) {
  std::string text = heavy_sheet;
  const std::string corners = R"(corners = ["last_first", "last_last"])";
  text.replace(text.find(corners), corners.size(), R"(edges = ["last_row"])");
  const std::string soft = "bending_stiffness = 1e-5";
  text.replace(text.find(soft), soft.size(), "bending_stiffness = 1e-2");
  Simulation relaxed = simulation_of(text, method("static", {"time.frames_per_second=30"}));
  Simulation stepped = simulation_of(
      text, method("euler",
                   {"time.step=0.01", "time.duration=3", "material.soft.stiffness_damping=0.02"}));
  advance_to(relaxed, 0.15);
  advance_to(stepped, 3);
  EXPECT_GT(strain_of(relaxed, relaxed.state(), 0.15), 0.04);  // it was put to the test
  const std::vector<Vec3> one = relaxed.position("sheet"), other = stepped.position("sheet");
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_LT((one[i] - other[i]).norm(), 1e-4) << i;
}

TEST(StrainLimit, ForcesAreSlopesOfTheEnergy) {
  const std::string stretched = R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.soft]
membrane_stiffness = 100
strain_limit = 0.2
[[body]]
name = "sheet"
stretch = [1.15, 1.12, 1]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 6] }
)";
  expect_consistent_forces(stretched, 0);
}

// Pins can stretch a sheet beyond any limit: the run ends at the limit and says so.
TEST(StrainLimit, EndsWhenPinsLeaveNoStateWithin) {
  for (const Method& each : std::vector<Method>{{"cvode", {}},
                                                {"arkode", {}},
                                                {"euler", {"time.step=0.005"}},
                                                {"static", {}},
                                                {"static", {"static.loading=\"in_time\""}}}) {
    SCOPED_TRACE(each.name + (each.more.empty() ? "" : ", " + each.more.back()));
    Simulation simulation = simulation_of(drawn_sheet, method(each.name, each.more));
    std::optional<Failure> failure;
    while (simulation.time() < 0.2 && !failure) failure = simulation.step();
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, Failure::Kind::strain_limit) << failure->text;
    EXPECT_NE(failure->text.find("the membrane would exceed its strain_limit at body \"sheet\""),
              std::string::npos)
        << failure->text;
    const double strain = strain_of(simulation, simulation.state(), simulation.time());
    EXPECT_LT(strain, 0.05);
    EXPECT_GT(strain, 0.03);
  }
}

TEST(StrainLimit, RefusesAStartBeyondIt) {
  const auto scene =
      build_scene(parse_case(heavy_sheet, "test.toml", {"body.sheet.stretch=[1.06,1,1]"}));
  try {
    check_initial_state(*scene);
    FAIL() << "accepted";
  } catch (const CaseError& error) {
    EXPECT_EQ(std::string(error.what()),
              "test.toml:15:1: at the start the membrane exceeds its strain_limit at body "
              "\"sheet\", row 0, column 0\n"
              "  expected a larger strain_limit, or a start that is stretched less");
  }
}

// Springs along rows, columns and diagonals are limited by the triangles between them.
TEST(StrainLimit, HoldsSpringsToo) {
  Simulation simulation = simulation_of(
      heavy_sheet, method("euler", {"time.step=0.005", "material.soft.membrane=\"springs\""}));
  while (simulation.time() < 0.15) {
    if (const auto failure = simulation.step()) FAIL() << failure->text;
    EXPECT_LT(strain_of(simulation, simulation.state(), simulation.time()), 0.05);
  }
}

// The limit is a force of its own, whatever the law of the membrane.
TEST(StrainLimit, HoldsWovenAndMeasuredClothToo) {
  std::string bare = heavy_sheet;
  const std::string stiffness = "membrane_stiffness = 100\n";
  bare.erase(bare.find(stiffness), stiffness.size());
  const std::string woven = "[material.soft.orthotropic_membrane]\nweft_stiffness = 150\n";
  for (const std::string& law :
       {woven + "warp_stiffness = 100\nshear_modulus = 5\n",
        woven + "warp_curve = { strains = [0, 0.05, 0.1], tensions = [0, 1, 11] }\n"
                "shear_modulus = 5\n",
        std::string("[material.soft.measured_membrane]\nwarp = [100, 120, 110, 100, 90, 80]\n"
                    "coupling = [20, 20, 20, 20, 20, 20]\nweft = [150, 90, 100, 120, 160, 180]\n"
                    "shear = [10, 10, 10, 10, 10, 10]\n")}) {
    SCOPED_TRACE(law);
    Simulation simulation = simulation_of(bare + law, method("euler", {"time.step=0.005"}));
    double largest = 0;
    while (simulation.time() < 0.15) {
      if (const auto failure = simulation.step()) FAIL() << failure->text;
      const double strain = strain_of(simulation, simulation.state(), simulation.time());
      EXPECT_LT(strain, 0.05);
      largest = std::max(largest, strain);
    }
    EXPECT_GT(largest, 0.04);
  }
}

// Any number of threads gives the same bits.
TEST(StrainLimit, DoesNotDependOnThreads) {
  std::vector<std::vector<double>> ends;
  for (const char* threads : {"compute.threads=1", "compute.threads=3"}) {
    Simulation simulation = simulation_of(
        heavy_sheet,
        method("euler", {"time.step=0.01", threads, "body.sheet.shape.resolution=[33,33]"}));
    for (int i = 0; i < 4; ++i) ASSERT_FALSE(simulation.step());
    ends.emplace_back(simulation.state().begin(), simulation.state().end());
  }
  EXPECT_EQ(ends[0], ends[1]);
}

// A sheet stretched by 8 % under a limit of 10 %: W = A E h (L^2 - c_0)^2 / 8 (1 - d)^3 / d. E h is
// that of the direction in which cloth is stiffest, or of the stiffest springs.
TEST(StrainLimit, IsAsStiffAsTheStiffestDirection) {
  const std::string woven =
      "[material.m.orthotropic_membrane]\nwarp_stiffness = 300\nweft_stiffness = "
      "800\nshear_modulus = 20\n";
  const std::string springs =
      "membrane = \"springs\"\nmembrane_stiffness = 100\nstructural_stiffness = 500\n";
  const double largest = 1.1 * 1.1, onset = 1.05 * 1.05, range = largest - onset;
  const double d = (largest - 1.08 * 1.08) / range;
  for (const auto& [keys, stiffness] : {std::pair(std::string("membrane_stiffness = 200\n"), 200.0),
                                        {woven, 800.0},
                                        {springs, 500.0}}) {
    const auto scene = build_scene(parse_case(
        "[contact]\nenabled = false\n[material.m]\nstrain_limit = 0.1\n" + keys +
            "[[body]]\nname = \"sheet\"\nstretch = [1.08, 1, 1]\nshape = { type = \"rectangle\", "
            "size = [0.2, 0.1], resolution = [4, 6] }\n",
        "test.toml", {}));
    Statistics statistics;
    Dynamics dynamics(*scene, statistics);
    double energy = 0;
    for (const auto& [name, value] : dynamics.energies(0, dynamics.initial_state()).elastic) {
      if (name == "strain_limit") energy = value;
    }
    const double exact = 0.2 * 0.1 * stiffness * range * range / 8 * std::pow(1 - d, 3) / d;
    EXPECT_NEAR(energy, exact, 1e-6 * exact) << keys;
  }
}

}  // namespace weft::sim::strain_limit_test
