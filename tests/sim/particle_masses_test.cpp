// Sums over particles in batches, against sums one by one.
#include "sim/motion/particle_masses.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

namespace weft::sim::particle_masses_test {
namespace {

TEST(ParticleMasses, WeighAndSlowDownAnyNumberOfParticles) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> entry(-1, 1);
  for (int count = 0; count <= 20; ++count) {
    SCOPED_TRACE(count);
    std::vector<double> mass(count);
    std::vector<Vec3> a(count), b(count), c(count);
    for (double& m : mass) m = 2 + entry(random);
    for (auto* vectors : {&a, &b, &c}) {
      for (Vec3& v : *vectors) v = Vec3::NullaryExpr([&] { return entry(random); });
    }
    double product = 0, bent = 0;
    Vec3 moment = Vec3::Zero();
    for (int i = 0; i < count; ++i) {
      product += mass[i] * a[i].dot(b[i]);
      bent += mass[i] * a[i].dot(2 * a[i] - b[i] - c[i]);
      moment += mass[i] * a[i];
    }
    EXPECT_NEAR(mass_product(mass, a, b), product, 1e-13);
    EXPECT_LT((mass_moment(mass, a) - moment).norm(), 1e-13);
    const VibrationProducts vibration = vibration_products(mass, b, a, c);
    EXPECT_NEAR(vibration.all, mass_product(mass, a, a), 1e-13);
    EXPECT_NEAR(vibration.bent, bent, 1e-13);
    const Vec3 gravity(1, 2, 3);
    std::vector<Vec3> slowed = a;
    const double sum = accelerate(mass, gravity, slowed);
    for (int i = 0; i < count; ++i)
      EXPECT_LT((slowed[i] - (gravity + a[i] / mass[i])).norm(), 1e-14) << i;
    EXPECT_NEAR(sum, std::accumulate(slowed.begin(), slowed.end(), Vec3(Vec3::Zero())).sum(),
                1e-12);
  }
}

}  // namespace
}  // namespace weft::sim::particle_masses_test
