#include "sim/solver/image_coarsening.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "sim/case/case_reader.h"

namespace weft::sim::image_coarsening_test {
namespace {

std::unique_ptr<const Scene> scene_of(const std::string& shape, const std::string& pin = "") {
  return build_scene(parse_case(
      "[contact]\nenabled = false\n[[body]]\nname = \"body\"\nshape = " + shape + "\n" + pin,
      "test.toml", {}));
}

std::unique_ptr<const Scene> shell_of(const std::string& shape, const std::string& pin = "") {
  return build_scene(parse_case(
      "[contact]\nenabled = false\n[material.solid]\nmodel = \"shell\"\nyoungs_modulus = 1e6\n"
      "poisson_ratio = 0.3\nshell_thickness = 0.01\nvolume_density = 1000\n[[body]]\nname = "
      "\"body\"\nshape = " +
          shape + "\n" + pin,
      "test.toml", {}));
}

std::string sheet(int rows, int cols) {
  return "{ type = \"rectangle\", size = [1.0, 1.0], resolution = [" + std::to_string(rows) + ", " +
         std::to_string(cols) + "] }";
}

// Returns, by coarse node, the fine node at its place.
std::vector<int> kept_nodes(const Prolongation& p) {
  std::vector<int> kept(p.coarse_count(), -1);
  for (int i = 0; i < p.fine_count(); ++i) {
    if (p.row_start[i + 1] == p.row_start[i] + 1 && p.weight[p.row_start[i]] == 1)
      kept[p.column[p.row_start[i]]] = i;
  }
  return kept;
}

// Checks that every level interpolates `value` of the finest nodes from the nodes it keeps, within
// the precision of single-precision weights.
void expect_reproduced(const Scene& scene, const std::function<double(int)>& value) {
  std::vector<double> fine;
  for (int i = 0; i < scene.dynamic_particles; ++i) fine.push_back(value(i));
  for (const Prolongation& p : coarsen_images(scene)) {
    std::vector<double> coarse;
    for (int node : kept_nodes(p)) {
      ASSERT_GE(node, 0);
      coarse.push_back(fine[node]);
    }
    for (int i = 0; i < p.fine_count(); ++i) {
      double sum = 0;
      for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k)
        sum += p.weight[k] * coarse[p.column[k]];
      ASSERT_NEAR(sum, fine[i], 1e-6 * (1 + std::abs(fine[i])));
    }
    fine = coarse;
  }
}

TEST(ImageCoarsening, ReproducesBilinearFunctionsOnSheetsOfAnySize) {
  for (const auto& [rows, cols] : {std::array{2, 2},
                                   {3, 7},
                                   {5, 5},
                                   {8, 6},
                                   {9, 17},
                                   {12, 31},
                                   {16, 16},
                                   {33, 33},
                                   {40, 97},
                                   {61, 30}}) {
    SCOPED_TRACE(std::to_string(rows) + " x " + std::to_string(cols));
    const auto scene = scene_of(sheet(rows, cols));
    expect_reproduced(*scene, [&](int i) {
      const int row = i / cols, col = i % cols;
      return 1 + 0.3 * row - 0.2 * col + 0.05 * row * col;
    });
  }
}

TEST(ImageCoarsening, ReproducesConstantsOnClosedAndSewnSurfaces) {
  for (const char* shape :
       {R"({ type = "cylinder", radius = 0.3, length = 1.0, resolution = [19, 23] })",
        R"({ type = "torus", major_radius = 0.5, minor_radius = 0.2, resolution = [16, 29] })",
        R"({ type = "torus", major_radius = 0.5, minor_radius = 0.2, resolution = [5, 4] })",
        R"({ type = "sphere", radius = 0.5, resolution = [13] })",
        R"({ type = "sphere", radius = 0.5, resolution = [16] })"}) {
    SCOPED_TRACE(shape);
    expect_reproduced(*scene_of(shape), [](int) { return 1.0; });
  }
}

// Every level of a shell has the control points of splines on fewer knots, and interpolates with
// weights that sum to 1.
TEST(ImageCoarsening, HalvesTheKnotsOfShells) {
  for (const char* shape :
       {"{ type = \"rectangle\", size = [1, 1], resolution = [19, 35] }",
        "{ type = \"cylinder\", radius = 0.3, length = 1.0, resolution = [19, 23] }",
        "{ type = \"torus\", major_radius = 0.5, minor_radius = 0.2, resolution = [16, 29] }",
        "{ type = \"sphere\", radius = 0.5, resolution = [19] }"}) {
    SCOPED_TRACE(shape);
    const auto scene = shell_of(shape);
    const auto levels = coarsen_images(*scene);
    EXPECT_GE(levels.size(), 2U);
    int count = scene->dynamic_particles;
    for (const Prolongation& p : levels) {
      ASSERT_EQ(p.fine_count(), count);
      EXPECT_LT(p.coarse_count(), 0.7 * count);
      for (int i = 0; i < p.fine_count(); ++i) {
        EXPECT_LE(p.row_start[i + 1] - p.row_start[i], 16);
        double sum = 0;
        for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k) sum += p.weight[k];
        EXPECT_NEAR(sum, 1, 1e-6);
      }
      count = p.coarse_count();
    }
  }
  // 14 x 32 elements and 7 x 16, the coarsest, as 7 cannot be halved.
  const auto levels =
      coarsen_images(*shell_of("{ type = \"rectangle\", size = [1, 1], "
                               "resolution = [17, 35] }"));
  ASSERT_EQ(levels.size(), 1U);
  EXPECT_EQ(levels[0].coarse_count(), 10 * 19);
}

TEST(ImageCoarsening, HalvesDownToAFewNodesAPatch) {
  for (int n : {17, 33, 50, 97, 128}) {
    const auto levels = coarsen_images(*scene_of(sheet(n, n)));
    int count = n * n;
    for (const Prolongation& p : levels) {
      ASSERT_EQ(p.fine_count(), count);
      EXPECT_LT(p.coarse_count(), 0.45 * count);
      count = p.coarse_count();
    }
    EXPECT_LE(count, 64);
  }
}

TEST(ImageCoarsening, LeavesWhatCannotBeCoarsenedToTheLastLevel) {
  const auto levels = coarsen_images(*scene_of(sheet(2, 51)));
  ASSERT_EQ(levels.size(), 1U);
  EXPECT_EQ(levels[0].coarse_count(), 102);
}

TEST(ImageCoarsening, FixedNodesHangOnNothing) {
  const auto scene = scene_of(sheet(17, 17),
                              "[[body.pin]]\nedges = [\"first_row\"]\n"
                              "[[body.pin]]\nrows = [9, 12]\ncols = [3, 9]\n");
  const auto levels = coarsen_images(*scene);
  const Prolongation& p = levels[0];
  int incomplete = 0;
  for (int i = 0; i < p.fine_count(); ++i) {
    double sum = 0;
    for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k) sum += p.weight[k];
    if (scene->pinned[i] != 0) {
      EXPECT_EQ(sum, 0);
    } else {
      EXPECT_GT(sum, 0);
      incomplete += sum < 1 - 1e-12 ? 1 : 0;
    }
  }
  EXPECT_LT(incomplete, 40);  // around the block that is pinned
  for (int c = 0; c < p.coarse_count(); ++c) EXPECT_GT(p.child_start[c + 1], p.child_start[c]);
}

TEST(ImageCoarsening, RestrictionIsTheTransposeOfProlongation) {
  const auto scene = scene_of(R"({ type = "sphere", radius = 0.5, resolution = [14] })");
  for (const Prolongation& p : coarsen_images(*scene)) {
    std::vector<Vec3> fine(p.fine_count()), coarse(p.coarse_count());
    for (Vec3& v : fine) v = Vec3::Random();
    for (Vec3& v : coarse) v = Vec3::Random();
    std::vector<Vec3> restricted(coarse.size()), prolongated(fine.size(), Vec3::Zero());
    p.restrict_to(fine, restricted, 1);
    p.add_to(coarse, prolongated, 1);
    double left = 0, right = 0;
    for (std::size_t i = 0; i < coarse.size(); ++i) left += coarse[i].dot(restricted[i]);
    for (std::size_t i = 0; i < fine.size(); ++i) right += fine[i].dot(prolongated[i]);
    EXPECT_NEAR(left, right, 1e-10);
  }
}

}  // namespace
}  // namespace weft::sim::image_coarsening_test
