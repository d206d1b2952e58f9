// The cases of cases/benchmarks: each is one that users can write, and ends where its reference
// says.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "../reference_value.h"
#include "bench/roof_paths.h"
#include "joint_cases.h"

namespace weft::sim::benchmark_case_test {
namespace {

std::string path_of(const std::string& name) {
  return std::string(WEFT_CASES_DIR) + "/benchmarks/" + name + ".toml";
}
Simulation benchmark(const std::string& name, const Overrides& overrides = {}) {
  return make_simulation(read_case(path_of(name), overrides));
}
std::string resolution(int rows, int cols) {
  return "body.0.shape.resolution=[" + std::to_string(rows) + "," + std::to_string(cols) + "]";
}
std::string frames(int per_second) {
  return "time.frames_per_second=" + std::to_string(per_second);
}

TEST(BenchmarkCases, CanBeBuilt) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(WEFT_CASES_DIR "/benchmarks")) {
    if (entry.path().extension() != ".toml") continue;
    EXPECT_NO_THROW(build_scene(read_case(entry.path().string()))) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 12);
}

// Returns, in order along a curve, 'o' where its projection to the plane z = 0 crosses over that of
// another curve, and 'u' where it crosses under it.
std::string crossings(const std::vector<Vec3>& curve, const std::vector<Vec3>& other) {
  std::string found;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    std::vector<std::pair<double, char>> here;
    for (std::size_t j = 0; j + 1 < other.size(); ++j) {
      const Vec3 along = curve[i + 1] - curve[i], across = other[j + 1] - other[j];
      const Vec3 from = other[j] - curve[i];
      const auto area = [](const Vec3& a, const Vec3& b) { return a.x() * b.y() - a.y() * b.x(); };
      const double s = area(from, across) / area(along, across);
      const double t = area(from, along) / area(along, across);
      if (!(s >= 0 && s < 1 && t >= 0 && t < 1)) continue;
      const double above = curve[i].z() + s * along.z() - other[j].z() - t * across.z();
      here.emplace_back(s, above > 0 ? 'o' : 'u');
    }
    std::ranges::sort(here);
    for (const auto& [place, way] : here) found += way;
  }
  return found;
}

// In a reef knot, both ends of a rope leave through the bight of the other on the same side.
TEST(BenchmarkCases, TheReefKnotIsAReefKnot) {
  const auto scene = build_scene(read_case(path_of("reef_knot")));
  std::vector<Vec3> middle[2];
  for (int b = 0; b < 2; ++b) {
    const SceneBody& body = scene->bodies[b];
    const bsi::Patch& tube = body.atlas.patches()[0];
    for (int row = 0; row < tube.rows; ++row) {
      Vec3 sum = Vec3::Zero();
      for (int col = 0; col < tube.cols; ++col)
        sum += scene->initial_position[body.first_particle + row * tube.cols + col];
      middle[b].push_back(sum / tube.cols);
    }
  }
  EXPECT_EQ(crossings(middle[0], middle[1]), "uouuou");
  EXPECT_EQ(crossings(middle[1], middle[0]), "ouoouo");
  EXPECT_EQ(crossings(middle[0], middle[0]), "");
}

struct Sagging {
  const char* gamma;  // weight per area L^3 / D
  int columns;
  double limit;
};
class HeavyElasticaCase : public testing::TestWithParam<Sagging> {};
TEST_P(HeavyElasticaCase, SagsAsTheElastica) {
  const auto& [gamma, columns, limit] = GetParam();
  const std::string full = std::to_string(-std::stod(gamma) / 12);
  Simulation sheet =
      benchmark("heavy_elastica",
                {resolution(4, columns), "world.gravity.values=[[0,0,0],[0,0," + full + "]]"});
  advance_to(sheet, 1);
  const std::vector<Vec3> x = sheet.position("sheet");
  const std::string name = std::string("heavy_elastica_") + gamma;
  const double drop = reference_value(name + "_drop"), reach = reference_value(name + "_reach");
  EXPECT_NEAR(-x[columns - 1].z(), drop, limit * drop);
  EXPECT_NEAR(x[columns - 1].x() + 0.5, reach, limit * reach);
}
INSTANTIATE_TEST_SUITE_P(All, HeavyElasticaCase,
                         testing::Values(Sagging{"1", 35, 5e-4}, Sagging{"10", 35, 5e-4},
                                         Sagging{"100", 35, 5e-4}, Sagging{"1000", 67, 2e-3}));

// The figures are those of elements that shear; on 6 x 33 control points, the plate is 0.7 % short
// of them.
TEST(BenchmarkCases, SlitPlateIsLifted) {
  Simulation plate = benchmark("slit_annular_plate", {resolution(6, 33), frames(10)});
  advance_to(plate, 1);
  const std::vector<Vec3> x = plate.position("plate");
  const double inner = reference_value("slit_annular_plate_inner");
  const double outer = reference_value("slit_annular_plate_outer");
  EXPECT_NEAR(x[5 * 33].z(), inner, 0.01 * inner);
  EXPECT_NEAR(x[0].z(), outer, 0.01 * outer);
}

// The point under the force gives way less than with elements that shear.
TEST(BenchmarkCases, OpenCylinderIsPulledApart) {
  constexpr int rows = 9, cols = 13;
  Simulation cylinder = benchmark("open_cylinder", {resolution(rows, cols), frames(20)});
  const std::vector<Vec3> start = cylinder.position("cylinder");
  advance_to(cylinder, 1);
  const std::vector<Vec3> x = cylinder.position("cylinder");
  const auto expect = [&](const char* point, double moved, double limit) {
    const double expected = reference_value(std::string("open_cylinder_") + point);
    EXPECT_NEAR(moved, expected, limit * expected) << point;
  };
  const int loaded = (rows - 1) * cols, side = rows * cols - 1, end = cols - 1;
  expect("loaded", x[loaded].x() - start[loaded].x(), 0.05);
  expect("side", start[side].y() - x[side].y(), 0.015);
  expect("free_end", start[end].y() - x[end].y(), 0.025);
}

// Returns the displacement of a loaded point of a hemisphere, at the end of a row of its image.
double pulled(const std::string& name, const Overrides& overrides) {
  Simulation hemisphere = benchmark(name, overrides);
  const double start = hemisphere.position("hemisphere")[0].x();
  advance_to(hemisphere, 1);
  return hemisphere.position("hemisphere")[0].x() - start;
}
TEST(BenchmarkCases, HemisphereIsTheSameInOneAndInFourPatches) {
  const double one = pulled("hemisphere_linear", {resolution(25, 25)});
  const double four = pulled("hemisphere_patches", {});
  EXPECT_NEAR(four, one, 1e-3 * one);
}

bench::RoofPath roof_by_arc_length(const Overrides& overrides = {}) {
  return bench::follow_by_arc_length(read_case(path_of("hinged_roof_arc_length"), overrides));
}

TEST(HingedRoof, SnapsThroughByArcLengthAsWhenPushed) {
  const bench::RoofPath path = roof_by_arc_length();
  const double limit = path.first_limit();
  EXPECT_NEAR(limit, reference_value("hinged_roof_limit_factor"),
              0.01 * reference_value("hinged_roof_limit_factor"));
  const bench::RoofPath points =
      bench::follow_by_displacement(read_case(path_of("hinged_roof_displacement"), {frames(2)}));
  ASSERT_EQ(points.factor.size(), 56);
  EXPECT_LT(bench::largest_distance(points, path), 0.005);
}

// The points of Sze, Liu and Lo 2004 on the path of the thinner roof, which snaps back.
TEST(HingedRoof, SnapsBackIfItIsThin) {
  const bench::RoofPath path = roof_by_arc_length(
      {"material.roof.shell_thickness=6.35", "static.largest_step=0.4", "time.duration=200"});
  const std::vector<std::pair<double, double>> points{
      {0.0517, 1.846},   {0.1583, 8.257},   {0.1953, 12.892},  {0.1806, 15.050},  {0.0923, 16.602},
      {0.0083, 17.008},  {-0.0622, 15.780}, {-0.0861, 14.767}, {-0.1142, 14.451}, {-0.1288, 15.778},
      {-0.1055, 19.817}, {-0.0006, 24.824}, {0.1427, 28.302},  {0.3559, 31.720},  {0.6417, 35.024}};
  for (const auto& [factor, deflection] : points)
    EXPECT_LT(path.distance(deflection, factor), 0.01) << deflection;
}

// A strip that stands exactly upright stays in its plane. It becomes unstable where the closed form
// says, a little later because its clamp holds the twist, too.
TEST(NarrowStrip, BecomesUnstableAtItsCriticalWeight) {
  Simulation strip = benchmark("narrow_strip", {"body.0.rotation_deg=[90,0,0]", frames(100),
                                                "body.0.shape.size=[1,0.02]", "time.duration=1.1"});
  double last_stable = 0;
  while (strip.time() < 1.1) {
    ASSERT_FALSE(strip.step());
    if (strip.integrator().path_point()->negative_directions == 0) last_stable = strip.time();
  }
  EXPECT_GT(last_stable, 0.99);
  EXPECT_LT(last_stable, 1.05);
}

TEST(NarrowStrip, GivesWaySidewaysBeyondIt) {
  Simulation strip = benchmark("narrow_strip");
  advance_to(strip, 0.9);
  EXPECT_LT(std::abs(strip.position("strip").back().y()), 0.01);
  advance_to(strip, 1.5);
  EXPECT_GT(std::abs(strip.position("strip").back().y()), 0.4);
}

}  // namespace
}  // namespace weft::sim::benchmark_case_test
