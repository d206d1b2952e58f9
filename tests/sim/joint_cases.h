// Helpers for tests of clamps, ties and starts.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/SparseCore>
#include <random>
#include <string>
#include <vector>

#include "sim/motion/mass_matrix.h"
#include "sim/run/make_simulation.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim {

inline Simulation simulation_of(const std::string& text, const Overrides& overrides = {}) {
  return make_simulation(parse_case(text, "test.toml", overrides));
}

inline void advance_to(Simulation& simulation, double time) {
  if (const auto failure = simulation.advance(time - simulation.time()))
    ADD_FAILURE() << failure->text;
}

inline Vec3 mean_of(const std::vector<Vec3>& all) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& each : all) sum += each;
  return sum / static_cast<double>(all.size());
}

// Compares a scene's forces with differences of their energies, together with what creases have
// dissipated, and their matrices with differences of their forces, at a random state near the start
// and at `time`. Forces are the mass matrix times the accelerations. Precondition: without contact
// and mass damping; moving pins rest at `time`.
inline void expect_consistent_forces(const std::string& text, double time) {
  const auto scene = build_scene(parse_case(text, "test.toml"));
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  const Eigen::SparseMatrix<double> mass = mass_matrix(*scene);
  std::vector<double> y = dynamics.initial_state();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> entry(-1, 1);
  const std::size_t half = y.size() / 2;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += (i < half ? 2e-3 : 0.1) * entry(random);
  std::vector<double> along(half);
  for (std::size_t i = 0; i < half; ++i)
    along[i] = scene->is_free(static_cast<int>(i / 3)) ? entry(random) : 0.0;
  const auto moved = [&](std::size_t offset, double by) {
    std::vector<double> other = y;
    for (std::size_t i = 0; i < half; ++i) other[offset + i] += by * along[i];
    return other;
  };
  const auto forces = [&](const std::vector<double>& state) {
    std::vector<Vec3> acceleration(scene->mass.size());
    EXPECT_FALSE(dynamics.acceleration(time, state, acceleration));
    std::vector<Vec3> all(acceleration.size(), Vec3::Zero());
    for (int j = 0; j < mass.outerSize(); ++j) {
      for (Eigen::SparseMatrix<double>::InnerIterator share(mass, j); share; ++share)
        all[share.row()] += share.value() * acceleration[j];
    }
    return all;
  };
  const auto product = [&](const std::vector<Vec3>& all) {
    double sum = 0;
    for (std::size_t i = 0; i < half; ++i) sum += all[i / 3][static_cast<int>(i % 3)] * along[i];
    return sum;
  };
  const std::vector<double> in_motion = y;
  // At rest there is no damping, which has no energy and of whose dependence on positions K leaves
  // a part out.
  std::fill(y.begin() + static_cast<std::ptrdiff_t>(half), y.end(), 0.0);
  constexpr double step = 1e-6;
  const auto potential = [&](double by) {
    const Energies energies = dynamics.energies(time, moved(0, by));
    return energies.total() + energies.dissipated.value_or(0);
  };
  const double slope = (potential(step) - potential(-step)) / (2 * step);
  EXPECT_NEAR(product(forces(y)), -slope, 1e-6 * std::abs(slope) + 1e-9);
  const auto expect_matrix = [&](const BlockMatrix& matrix, std::size_t offset) {
    std::vector<Vec3> in(scene->mass.size()), out(scene->mass.size());
    for (std::size_t i = 0; i < half; ++i) in[i / 3][static_cast<int>(i % 3)] = along[i];
    matrix.multiply(in, out, 1);
    const auto before = forces(moved(offset, -step)), after = forces(moved(offset, step));
    double scale = 0;
    for (const Vec3& each : out) scale = std::max(scale, each.norm());
    ASSERT_GT(scale, 0);
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (!scene->is_free(static_cast<int>(i))) continue;
      EXPECT_LT((out[i] - (before[i] - after[i]) / (2 * step)).norm(), 1e-5 * scale)
          << "particle " << i;
    }
  };
  dynamics.assemble(time, y);
  expect_matrix(dynamics.stiffness(), 0);
  y = in_motion;
  dynamics.assemble(time, y);
  if (!dynamics.has_damping()) return;
  expect_matrix(dynamics.damping(), half);
  // Joined for one gamma, the matrix is K + D / gamma, and the product D r.
  constexpr double gamma = 0.01;
  std::vector<Vec3> in(scene->mass.size()), stiff(in.size()), damped(in.size()), joined(in.size());
  for (std::size_t i = 0; i < half; ++i) in[i / 3][static_cast<int>(i % 3)] = along[i];
  dynamics.stiffness().multiply(in, stiff, 1);
  dynamics.damping().multiply(in, damped, 1);
  dynamics.assemble_joined(time, y, Definiteness::exact, gamma, in);
  dynamics.stiffness().multiply(in, joined, 1);
  for (std::size_t i = 0; i < in.size(); ++i) {
    const Vec3 expected = stiff[i] + damped[i] / gamma;
    EXPECT_LT((joined[i] - expected).norm(), 1e-9 * (1 + expected.norm())) << i;
    EXPECT_LT((dynamics.damping_product()[i] - damped[i]).norm(), 1e-9 * (1 + damped[i].norm()));
  }
}

}  // namespace weft::sim
