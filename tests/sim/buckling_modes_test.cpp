// Critical load factors against closed forms.
#include <omp.h>

#include <cmath>
#include <numbers>

#include "../reference_value.h"
#include "mode_case.h"

namespace weft::sim::buckling_modes_test {
namespace {

constexpr double pi = std::numbers::pi;

TEST(PlateBuckling, IsThatOfTheClosedForm) {
  const BucklingModes found = buckling_of(benchmark_case("plate_buckling"), 3);
  ASSERT_EQ(found.modes.size(), 3U);
  // k = (m / a + a / m)^2 pi^2 D / b^2 for m half waves along the load. The error of cubic splines
  // goes with the fourth power of m: it is -1.7e-5, -3.6e-4 and -1.75e-3 with 13 elements.
  for (const int m : {1, 2, 3}) {
    const double exact = std::pow(m + 1.0 / m, 2) * pi * pi;
    EXPECT_NEAR(found.modes[m - 1].load_factor, exact, 2.5e-5 * std::pow(m, 4) * exact) << m;
    EXPECT_LT(found.modes[m - 1].error, 1e-10);
  }
}

// Tension buckles nothing: the factors are those of the reversed load.
TEST(PlateBuckling, OfTheReversedLoadHasTheOtherSign) {
  const BucklingModes found =
      buckling_of(benchmark_case("plate_buckling", {"load.0.force=[1, 0, 0]"}), 1);
  ASSERT_EQ(found.modes.size(), 1U);
  EXPECT_NEAR(found.modes[0].load_factor, -4 * pi * pi, 1e-3 * 4 * pi * pi);
}

// Twice the reference load has half the factor. Half of the critical load as prestress leaves the
// same critical one.
TEST(PlateBuckling, ScalesWithTheLoadAndCountsThePrestress) {
  const double once = buckling_of(benchmark_case("plate_buckling"), 1).modes[0].load_factor;
  const double twice = buckling_of(benchmark_case("plate_buckling", {"load.0.force=[-2, 0, 0]"}), 1)
                           .modes[0]
                           .load_factor;
  EXPECT_NEAR(twice, once / 2, 1e-7 * once);
  // The stress of St. Venant and Kirchhoff is not linear in the load: 2e-4 of strain shows.
  const double stressed =
      buckling_of(benchmark_case("plate_buckling"), 1, 0.5 * once).modes[0].load_factor;
  EXPECT_NEAR(stressed, once, 2e-3 * once);
}

TEST(EulerColumn, BucklesAtTheCriticalLoads) {
  const BucklingModes found = buckling_of(benchmark_case("euler_column"), 2);
  ASSERT_EQ(found.modes.size(), 2U);
  const double first = reference_value("euler_clamped_free") * 1e-3;
  EXPECT_NEAR(found.modes[0].load_factor, first, 1e-4 * first);
  EXPECT_NEAR(found.modes[1].load_factor, 9 * first, 1e-3 * 9 * first);
}

// Supports by axes: the ends slide along the load.
TEST(EulerColumn, CanBeHeldOtherwise) {
  Case source = benchmark_case("euler_column");
  PinCase sliding;
  sliding.vertices.edges = {"last_col"};
  sliding.axes = {"z"};
  source.body[0].pin.push_back(sliding);
  const double propped = reference_value("euler_clamped_pinned") * 1e-3;
  EXPECT_NEAR(buckling_of(source, 1).modes[0].load_factor, propped, 5e-4 * propped);
  source.body[0].pin[0].clamp = false;
  const double pinned = reference_value("euler_pinned_pinned") * 1e-3;
  EXPECT_NEAR(buckling_of(source, 1).modes[0].load_factor, pinned, 1e-4 * pinned);
}

TEST(ColumnUnderWeight, BucklesAtTheLoadOfGreenhill) {
  const BucklingModes found = buckling_of(benchmark_case("column_under_weight"), 1);
  ASSERT_EQ(found.modes.size(), 1U);
  const double exact = reference_value("self_weight_column") * 1e-2 / 0.981;
  EXPECT_NEAR(found.modes[0].load_factor, exact, 1e-3 * exact);
}

// The load at which a mode stops vibrating is the critical one.
TEST(Buckling, IsWhereTheLowestFrequencyVanishes) {
  const double factor = buckling_of(benchmark_case("euler_column"), 1).modes[0].load_factor;
  const auto eigenvalue = [&](double part) {
    const std::string force = "load.0.force=[" + std::to_string(-10 * part * factor) + ", 0, 0]";
    return modes_of(benchmark_case("euler_column", {force}), 1).modes[0].eigenvalue;
  };
  EXPECT_GT(eigenvalue(0.99), 0);
  EXPECT_LT(eigenvalue(1.01), 0);
  EXPECT_NEAR(eigenvalue(0.99) / eigenvalue(0), 0.01, 1e-3);
}

TEST(Buckling, HasTheSameBitsForAnyNumberOfThreads) {
  std::vector<BucklingModes> found;
  for (const int threads : {1, 3}) {
    omp_set_num_threads(threads);
    found.push_back(buckling_of(
        benchmark_case("plate_buckling", {"compute.threads=" + std::to_string(threads)}), 4));
  }
  omp_set_num_threads(omp_get_num_procs());
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(found[0].modes[i].load_factor, found[1].modes[i].load_factor);
    EXPECT_EQ(found[0].modes[i].shape, found[1].modes[i].shape);
  }
}

std::string failure_of(const Case& source, double load_factor = 0) {
  const BucklingModes found = buckling_of(source, 1, load_factor);
  EXPECT_TRUE(found.modes.empty());
  return found.failure ? found.failure->text : "";
}

TEST(Buckling, FailsWithTheReason) {
  Case loose = benchmark_case("euler_column");
  loose.body[0].pin.clear();
  EXPECT_NE(failure_of(loose).find("is singular; it is weakest at body \"column\""),
            std::string::npos);
  // Beyond the critical load the column is unstable.
  EXPECT_NE(failure_of(benchmark_case("euler_column"), 3e-3).find("unstable"), std::string::npos);
  // A load on the clamp moves nothing.
  Case held = benchmark_case("euler_column");
  held.load[0].vertices.edges = {"first_col"};
  EXPECT_EQ(failure_of(held), "the loads move nothing");
}

// A plate of side 1 that its edges hold across its plane. Loads compress it.
std::string compressed_plate(double thickness, int resolution, const std::string& more_pins) {
  const std::string size = std::to_string(resolution);
  std::string text = R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.plate]
model = "shell"
youngs_modulus = 1.092e7
poisson_ratio = 0.3
volume_density = 100
shell_thickness = )" +
                     std::to_string(thickness) + R"(
[[body]]
name = "plate"
shape = { type = "rectangle", size = [1, 1], resolution = [)" +
                     size + ", " + size + R"(] }
[[body.pin]]
edges = ["first_row", "last_row", "first_col", "last_col"]
axes = ["z"]
)" + more_pins;
  for (const auto& [edge, sign] : {std::pair{"last_col", "-1"}, std::pair{"first_col", "1"}})
    text += std::string("[[load]]\nbody = \"plate\"\ntype = \"line\"\nedges = [\"") + edge +
            "\"]\nforce = [" + sign + ", 0, 0]\n";
  return text;
}
std::string corner_pin(const std::string& corners, const std::string& axis) {
  return "[[body.pin]]\ncorners = [" + corners + "]\naxes = [\"" + axis + "\"]\n";
}

// Supports along x and y at opposite corners leave a rotation in the plane. Rounding decides
// whether its pivot is positive.
TEST(Buckling, RefusesAFreeRotationWhateverItsRounding) {
  const std::string corners = corner_pin("\"first_first\"", "x") + corner_pin("\"last_last\"", "y");
  for (const int resolution : {5, 6, 7, 8, 9, 10, 12, 16}) {
    const Case source = parse_case(compressed_plate(0.01, resolution, corners), "test.toml");
    EXPECT_NE(failure_of(source).find("is singular; it is weakest at body \"plate\""),
              std::string::npos)
        << resolution;
  }
}

// Its bending is 1e-8 times as stiff as its stretching, and is mixed with it in tilted axes.
TEST(Buckling, AcceptsAThinTiltedPlate) {
  const std::string held = "[[body.pin]]\nedges = [\"first_col\"]\n";
  const auto lowest = [&](double thickness) {
    const Case source = parse_case(compressed_plate(thickness, 17, held), "test.toml",
                                   {"body.plate.rotation_deg=[20, 30, 40]"});
    const BucklingModes found = buckling_of(source, 1);
    EXPECT_FALSE(found.failure) << found.failure->text;
    return found.failure ? 0 : found.modes[0].load_factor / std::pow(thickness, 3);
  };
  EXPECT_NEAR(lowest(1e-4) / lowest(1e-2), 1, 0.05);
}

std::string refusal_of(const Case& source) {
  try {
    require_load(source);
  } catch (const CaseError& error) {
    return error.what();
  }
  return "";
}

TEST(Buckling, NeedsALoad) {
  const std::string text = R"([material.steel]
model = "shell"
youngs_modulus = 1e6
shell_thickness = 0.01
volume_density = 1000
[[body]]
name = "strip"
shape = { type = "rectangle", size = [1, 1], resolution = [4, 4] }
)";
  EXPECT_EQ(refusal_of(parse_case(text, "test.toml")),
            "test.toml:6:1: nothing loads the case: buckling is sought at multiples of its loads\n"
            "  expected a [[load]], or gravity with static.scale_gravity = true");
  const std::string load = R"([[load]]
body = "strip"
type = "line"
edges = ["last_col"]
force = [0, 0, 0]
)";
  EXPECT_EQ(refusal_of(parse_case(text + load, "test.toml")),
            "test.toml:9:1: the loads are zero: buckling is sought at multiples of them\n"
            "  expected a [[load]], or gravity with static.scale_gravity = true");
}

}  // namespace
}  // namespace weft::sim::buckling_modes_test
