// The mass matrix in the equations of motion, with its products and its inverse.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/motion/particle_masses.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The mass matrix M of the dynamic particles (mass_matrix.h). One M serves all three axes. Without
// shells, or with lumped masses, M is diagonal, and its products cost as little as those of
// particle_masses.h. With consistent shells, M stores one number per upper block of the pattern
// given to attach().
class MassOperator {
 public:
  // `lumped`: Scene::mass on the diagonal, for shells too. `consistent`: mass_matrix().
  enum class Form : std::uint8_t { lumped, consistent };
  // The scene must outlive the object.
  MassOperator(const Scene& scene, Form form);
  ~MassOperator();
  MassOperator(const MassOperator&) = delete;
  MassOperator& operator=(const MassOperator&) = delete;

  bool is_diagonal() const { return is_diagonal_; }
  // Adds to neighbours[i] the particles that M couples to particle i.
  void add_couplings(std::vector<std::vector<int>>& neighbours) const;
  // Sets the block pattern, which must contain the pairs of add_couplings(). Must be called once,
  // before all functions below.
  void attach(std::shared_ptr<const BlockPattern> pattern);

  // Returns the entry (kg) at a slot of a row of the pattern.
  double at(int row, int slot) const {
    if (is_diagonal_) return slot == pattern_->diagonal_slot(row) ? scene_.mass[row] : 0;
    return entries_[pattern_->upper(row, slot)];
  }
  // Returns row `row` of the product M in.
  Vec3 row_product(int row, const Vec3* in) const {
    return is_diagonal_ ? Vec3(scene_.mass[row] * in[row]) : coupled_product(row, in);
  }
  // Computes out = M in.
  void multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const;
  // Returns a . M b.
  double product(std::span<const Vec3> a, std::span<const Vec3> b, int threads) const;
  // Returns the sums of vibration_products() (particle_masses.h) with this M.
  VibrationProducts vibration(std::span<const Vec3> before, std::span<const Vec3> a,
                              std::span<const Vec3> after, int threads) const;
  // Replaces the forces F (N) on the free particles by M_ff^-1 F (m/s^2), where M_ff has the rows
  // and columns of the free particles. Entries of held particles become zero. If M is not diagonal,
  // the first call factorises M_ff, and each call costs two passes over the factor, on one thread.
  void solve(std::span<Vec3> force);

 private:
  class Factor;
  Vec3 coupled_product(int row, const Vec3* in) const;

  const Scene& scene_;
  bool is_diagonal_;
  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<double> entries_;  // entries (kg), one per upper block; empty if M is diagonal
  std::unique_ptr<Factor> factor_;
};

}  // namespace weft::sim
