#include "bsi/sphere_hierarchy.h"

#include <gtest/gtest.h>

#include <random>

namespace weft::bsi::sphere_hierarchy_test {
namespace {

struct Spheres {
  std::vector<Vec3> centres;
  std::vector<double> radii;
};

Spheres random_spheres(int count, double flatness, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1, 1), radius(0.001, 0.08);
  Spheres spheres;
  for (int i = 0; i < count; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    spheres.centres.emplace_back(x, y, flatness * z);
    spheres.radii.push_back(radius(random));
  }
  return spheres;
}

std::vector<LeafPair> all_near_pairs(const Spheres& spheres, double margin) {
  std::vector<LeafPair> pairs;
  const int count = static_cast<int>(spheres.centres.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      const double gap =
          (spheres.centres[a] - spheres.centres[b]).norm() - spheres.radii[a] - spheres.radii[b];
      if (gap <= margin) pairs.push_back({a, b});
    }
  }
  return pairs;
}

TEST(SphereHierarchy, FindsThePairsOfBruteForce) {
  for (const int count : {0, 1, 2, 7, 8, 9, 33, 300, 1000}) {
    for (const double margin : {0.0, 0.01, 0.3}) {
      for (const double flatness : {0.0, 0.01, 1.0}) {
        const Spheres spheres = random_spheres(count, flatness, 7 + count);
        SphereHierarchy hierarchy;
        hierarchy.rebuild(spheres.centres, spheres.radii);
        std::int64_t tests = 0;
        EXPECT_EQ(hierarchy.near_pairs(margin, tests), all_near_pairs(spheres, margin))
            << count << " spheres, margin " << margin << ", flatness " << flatness;
      }
    }
  }
}

TEST(SphereHierarchy, FindsSpheresAtOnePlace) {
  const std::vector<Vec3> centres(20, Vec3(3, 4, 5));
  const std::vector<double> radii(20, 0.0);
  SphereHierarchy hierarchy;
  hierarchy.rebuild(centres, radii);
  std::int64_t tests = 0;
  EXPECT_EQ(hierarchy.near_pairs(0, tests).size(), 190U);
}

TEST(SphereHierarchy, ComparesFewSpheres) {
  const Spheres spheres = random_spheres(20000, 1, 3);
  const std::vector<double> small(spheres.centres.size(), 0.002);
  SphereHierarchy hierarchy;
  hierarchy.rebuild(spheres.centres, small);
  std::int64_t tests = 0;
  hierarchy.near_pairs(0.001, tests);
  EXPECT_LT(tests, 20000 * 150);
  const std::int64_t once = tests;
  hierarchy.near_pairs(0.001, tests);
  EXPECT_EQ(tests, 2 * once);
}

}  // namespace
}  // namespace weft::bsi::sphere_hierarchy_test
