#include "sim/integrator/direct_solver.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <vector>

namespace weft::sim {

struct DirectSolver::Implementation {
  explicit Implementation(Dynamics& dynamics_) : dynamics(dynamics_) {}
  void add_block(int row, int column, const Mat3& block);
  void assemble(double gamma);
  Eigen::VectorXd right_side(double gamma, const StateView& b) const;

  Dynamics& dynamics;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::SparseMatrix<double> matrix;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors;
};

// The lower half is enough.
void DirectSolver::Implementation::add_block(int row, int column, const Mat3& block) {
  const std::vector<char>& pinned = dynamics.scene().pinned;
  if (pinned[row] != 0 || pinned[column] != 0) return;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (3 * row + i >= 3 * column + j) {
        entries.emplace_back(3 * row + i, 3 * column + j, block(i, j));
      }
    }
  }
}

void DirectSolver::Implementation::assemble(double gamma) {
  entries.clear();
  const BlockMatrix &stiffness = dynamics.stiffness(), &damping = dynamics.damping();
  const BlockPattern& pattern = stiffness.pattern();
  for (int row = 0; row < pattern.rows(); ++row) {
    for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot) {
      add_block(row, pattern.column(slot),
                gamma * (gamma * stiffness.block(slot) + damping.block(slot)));
    }
    const double mass = dynamics.scene().mass[row];
    for (int i = 0; i < 3; ++i) entries.emplace_back(3 * row + i, 3 * row + i, mass);
  }
  if (dynamics.contact() != nullptr) {
    dynamics.contact()->visit_blocks(
        gamma, [&](int row, int column, const Mat3& block) { add_block(row, column, block); });
  }
  matrix.resize(3 * pattern.rows(), 3 * pattern.rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
}

// M b_v - gamma K b_x, as in VelocitySystem.
Eigen::VectorXd DirectSolver::Implementation::right_side(double gamma, const StateView& b) const {
  const int count = dynamics.particle_count();
  std::vector<Vec3> product(count);
  dynamics.stiffness().multiply(b.position, product, dynamics.threads());
  for (Vec3& p : product) p *= -gamma;
  if (dynamics.contact() != nullptr)
    dynamics.contact()->subtract_stiffness(gamma, b.position, product);
  Eigen::VectorXd result(3 * count);
  for (int i = 0; i < count; ++i) {
    const bool held = dynamics.scene().pinned[i] != 0;
    result.segment<3>(3 * i) =
        held ? Vec3(Vec3::Zero()) : Vec3(product[i] + dynamics.scene().mass[i] * b.velocity[i]);
  }
  return result;
}

DirectSolver::DirectSolver(Dynamics& dynamics)
    : implementation_(std::make_unique<Implementation>(dynamics)) {}
DirectSolver::~DirectSolver() = default;

bool DirectSolver::solve(double gamma, std::span<const double> b, std::span<double> correction) {
  Implementation& self = *implementation_;
  self.assemble(gamma);
  self.factors.compute(self.matrix);
  if (self.factors.info() != Eigen::Success) return false;
  if (!(self.factors.vectorD().minCoeff() > 0)) return false;
  const StateView right = StateView::of(b);
  const Eigen::VectorXd dv = self.factors.solve(self.right_side(gamma, right));
  if (!dv.allFinite()) return false;
  const int count = self.dynamics.particle_count();
  auto* x = reinterpret_cast<Vec3*>(correction.data());
  for (int i = 0; i < count; ++i) {
    x[count + i] = dv.segment<3>(3 * i);
    x[i] = self.dynamics.scene().pinned[i] != 0 ? Vec3(Vec3::Zero())
                                                : Vec3(right.position[i] + gamma * x[count + i]);
  }
  return true;
}

}  // namespace weft::sim
