// Candidates of spheres: pairs by a grid, and cached triangles, compared with brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "bsi/proximity.h"
#include "sim/case/case_reader.h"
#include "sim/particles/sphere_grid.h"
#include "sim/particles/sphere_search.h"
#include "sim/particles/surface_candidates.h"

namespace weft::sim::sphere_candidates_test {
namespace {

// Returns the pairs whose surfaces touch or overlap, in ascending order.
std::vector<std::pair<int, int>> brute_force(std::span<const Vec3> x, std::span<const double> r) {
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t a = 0; a < x.size(); ++a) {
    for (std::size_t b = a + 1; b < x.size(); ++b) {
      const double reach = r[a] + r[b];
      if ((x[a] - x[b]).squaredNorm() <= reach * reach)
        pairs.emplace_back(static_cast<int>(a), static_cast<int>(b));
    }
  }
  return pairs;
}

TEST(SphereGrid, FindsThePairsOfBruteForce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 1), size(0, 1);
  SphereGrid grid;
  SpherePairs pairs;
  for (const double ratio : {1.0, 3.0, 1000.0}) {
    for (const int count : {0, 1, 2, 40, 700}) {
      std::vector<Vec3> x(count);
      std::vector<double> r(count);
      for (int i = 0; i < count; ++i) {
        x[i] = {place(random), place(random), place(random)};
        r[i] = 0.06 * std::pow(ratio, -size(random));
      }
      // A sphere far away shares the outermost cells.
      if (count > 2) x[1] = {1e12, -1e12, 0};
      grid.find_pairs(x, r, pairs);
      std::vector<std::pair<int, int>> found;
      for (int a = 0; a < count; ++a) {
        for (const int b : pairs.of(a)) found.emplace_back(a, b);
      }
      EXPECT_EQ(found, brute_force(x, r)) << "ratio " << ratio << ", " << count << " spheres";
    }
  }
}

const std::string torus = R"(
[time]
method = "impulses"
duration = 1
[[particles]]
name = "balls"
radius = 0.02
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 1] }
[[obstacle]]
name = "torus"
shape = { type = "torus", major_radius = 0.15, minor_radius = 0.05, resolution = [24, 12] }
)";

TEST(SurfaceCandidates, HoldAllNearTrianglesDuringALongMotion) {
  const auto scene = build_scene(parse_case(torus, "torus.toml"));
  const SphereSurfaces surfaces(*scene);
  const ObstacleSurface& surface = surfaces.all()[0];
  constexpr int spheres = 40, steps = 400;
  const std::vector<double> radii(spheres, 0.02);
  SurfaceCandidates candidates(surface, radii);
  std::mt19937 random(5);
  std::normal_distribution<double> step(0, 1e-3);
  std::vector<Vec3> x(spheres, Vec3(0.2, 0, 0.06));
  const double need = 1.5e-3, wish = 8e-3;
  std::int64_t near = 0;
  for (int k = 0; k < steps; ++k) {
    for (int i = 0; i < spheres; ++i) {
      x[i] += Vec3(step(random), step(random), step(random));
      candidates.cover(i, x[i], need, wish);
      if (k % 3 == 0) candidates.measure(i, x[i], 1e-3);
      const double moved = candidates.moved(i, x[i]);
      for (int t = 0; t < static_cast<int>(surface.mesh->triangles.size()); ++t) {
        const auto& [a, b, c] = surface.mesh->triangles[t];
        const double gap =
            std::sqrt(bsi::closest_vertex_triangle(x[i], surface.vertices[a], surface.vertices[b],
                                                   surface.vertices[c])
                          .squared_distance) -
            0.02 - surface.half_thickness;
        if (gap > need) continue;
        ++near;
        const auto list = candidates.of(i);
        const auto found = std::ranges::find(list, t, &NearTriangle::triangle);
        ASSERT_NE(found, list.end()) << "sphere " << i << ", step " << k << ", triangle " << t;
        ASSERT_LE(found->gap - moved, gap + 1e-12);
        ASSERT_LE(candidates.least_gap(i) - moved, gap + 1e-12);
      }
    }
  }
  EXPECT_GT(near, 1000);
  EXPECT_LT(candidates.lists_made(), spheres * steps / 3);
}

TEST(SphereSearch, FindsOverlapsBetweenTheEndsOfAStep) {
  const auto scene =
      build_scene(parse_case(torus, "torus.toml", {"particles.0.positions.count=[2, 1, 1]"}));
  const SphereSurfaces surfaces(*scene);
  SphereLaws laws(*scene);
  laws.set_friction(0);
  Statistics statistics;
  SphereSearch search(*scene, surfaces, laws, statistics);
  const std::vector<RigidPose> poses = surfaces.poses(0);
  const std::vector<Vec3> rest(2, Vec3::Zero());
  // The spheres pass each other, and touch while they are abreast.
  for (const auto& [apart, way] :
       {std::pair(0.0396, 0.007), {0.0401, 0.007}, {0.0396, 0.3}, {0.0401, 0.3}}) {
    const std::vector<Vec3> x{{-way, 0, 1}, {0, apart, 1}}, end{{way, 0, 1}, {0, apart, 1}};
    const SphereStart start{x, rest, rest, poses, poses, 1};
    std::vector<SphereContact> overlaps;
    search.find_overlaps(start, end, {}, overlaps);
    EXPECT_EQ(overlaps.size(), apart < 0.04 ? 1U : 0U);
    search.find_overlaps(start, end, std::vector<char>{0, 0}, overlaps);
    EXPECT_TRUE(overlaps.empty());
    // Spheres that part have no overlap that they could lose.
    search.find_overlaps(start, x, {}, overlaps);
    EXPECT_TRUE(overlaps.empty());
  }
}

}  // namespace
}  // namespace weft::sim::sphere_candidates_test
