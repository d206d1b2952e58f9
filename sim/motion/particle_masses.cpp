#include "sim/motion/particle_masses.h"

#include <array>
#include <cassert>

#include "materials/lanes.h"

namespace weft::sim {

namespace {

using materials::lane_count;
using materials::Lanes;
using materials::UnalignedLanes;

// Number of lane vectors that hold the coordinates of a batch of particles.
constexpr int rows = 3;

Lanes load(const double* at) { return Lanes(*reinterpret_cast<const UnalignedLanes*>(at)); }
void store(Lanes numbers, double* at) { *reinterpret_cast<UnalignedLanes*>(at) = numbers.values; }

std::size_t whole_batches(std::size_t count) { return count - count % lane_count; }

// Returns row `row` of a batch whose particles all have the vector `v`.
Lanes repeated(const Vec3& v, int row) {
  Lanes numbers;
  for (int lane = 0; lane < lane_count; ++lane)
    numbers.values[lane] = v[(row * lane_count + lane) % 3];
  return numbers;
}

}  // namespace

double mass_product(std::span<const double> mass, std::span<const Vec3> a,
                    std::span<const Vec3> b) {
  assert(mass.size() == a.size() && a.size() == b.size());
  std::array<Lanes, rows> sums{};
  const std::size_t whole = whole_batches(a.size());
  for (std::size_t i = 0; i < whole; i += lane_count) {
    const auto masses = materials::threefold(load(&mass[i]));
    for (int row = 0; row < rows; ++row) {
      const std::ptrdiff_t at = row * lane_count;
      sums[row] += masses[row] * load(a[i].data() + at) * load(b[i].data() + at);
    }
  }
  double sum = materials::sum_of_lanes(sums[0] + sums[1] + sums[2]);
  for (std::size_t i = whole; i < a.size(); ++i) sum += mass[i] * a[i].dot(b[i]);
  return sum;
}

VibrationProducts vibration_products(std::span<const double> mass, std::span<const Vec3> before,
                                     std::span<const Vec3> a, std::span<const Vec3> after) {
  assert(mass.size() == a.size() && a.size() == before.size() && a.size() == after.size());
  std::array<Lanes, rows> all{}, bent{};
  const std::size_t whole = whole_batches(a.size());
  for (std::size_t i = 0; i < whole; i += lane_count) {
    const auto masses = materials::threefold(load(&mass[i]));
    for (int row = 0; row < rows; ++row) {
      const std::ptrdiff_t at = row * lane_count;
      const Lanes now = load(a[i].data() + at), weighted = masses[row] * now;
      all[row] += weighted * now;
      bent[row] +=
          weighted * (2.0 * now - load(before[i].data() + at) - load(after[i].data() + at));
    }
  }
  VibrationProducts sums{materials::sum_of_lanes(all[0] + all[1] + all[2]),
                         materials::sum_of_lanes(bent[0] + bent[1] + bent[2])};
  for (std::size_t i = whole; i < a.size(); ++i) {
    sums.all += mass[i] * a[i].squaredNorm();
    sums.bent += mass[i] * a[i].dot(2 * a[i] - before[i] - after[i]);
  }
  return sums;
}

Vec3 mass_moment(std::span<const double> mass, std::span<const Vec3> x) {
  assert(mass.size() == x.size());
  std::array<Lanes, rows> sums{};
  const std::size_t whole = whole_batches(x.size());
  for (std::size_t i = 0; i < whole; i += lane_count) {
    const auto masses = materials::threefold(load(&mass[i]));
    for (int row = 0; row < rows; ++row)
      sums[row] += masses[row] * load(x[i].data() + row * lane_count);
  }
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < rows * lane_count; ++i)
    sum[i % 3] += sums[i / lane_count].values[i % lane_count];
  for (std::size_t i = whole; i < x.size(); ++i) sum += mass[i] * x[i];
  return sum;
}

double accelerate(std::span<const double> mass, const Vec3& gravity, std::span<Vec3> force) {
  assert(mass.size() == force.size());
  const std::array<Lanes, rows> fall{repeated(gravity, 0), repeated(gravity, 1),
                                     repeated(gravity, 2)};
  std::array<Lanes, rows> sums{};
  const std::size_t whole = whole_batches(force.size());
  for (std::size_t i = 0; i < whole; i += lane_count) {
    const auto inverse = materials::threefold(1.0 / load(&mass[i]));
    for (int row = 0; row < rows; ++row) {
      double* at = force[i].data() + row * lane_count;
      const Lanes acceleration = fall[row] + inverse[row] * load(at);
      store(acceleration, at);
      sums[row] += acceleration;
    }
  }
  double sum = materials::sum_of_lanes(sums[0] + sums[1] + sums[2]);
  for (std::size_t i = whole; i < force.size(); ++i) {
    force[i] = gravity + (1 / mass[i]) * force[i];
    sum += force[i].sum();
  }
  return sum;
}

}  // namespace weft::sim
