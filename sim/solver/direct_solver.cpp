#include "sim/solver/direct_solver.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace weft::sim {

struct DirectSolver::Implementation {
  explicit Implementation(Dynamics& dynamics_) : dynamics(dynamics_) {}
  void add_block(int block_row, int block_column, const Mat3& block);
  void assemble(double gamma);
  void compress(int size);

  Dynamics& dynamics;
  // An entry of the lower half of A. Entries with equal row and column are summed.
  struct Entry {
    int column = 0, row = 0;
    double value = 0;
  };
  std::vector<Entry> entries;
  std::vector<int> column_start, row, analysed_start, analysed_row;
  std::vector<double> value;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors;
};

// Adds the part of a block that lies in the lower half of A. The factorisation reads only that
// half.
void DirectSolver::Implementation::add_block(int block_row, int block_column, const Mat3& block) {
  const std::vector<char>& pinned = dynamics.scene().pinned;
  if (pinned[block_row] != 0 || pinned[block_column] != 0) return;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (3 * block_row + i >= 3 * block_column + j) {
        entries.push_back({3 * block_column + j, 3 * block_row + i, block(i, j)});
      }
    }
  }
}

void DirectSolver::Implementation::assemble(double gamma) {
  entries.clear();
  const BlockMatrix &stiffness = dynamics.stiffness(), &damping = dynamics.damping();
  const BlockPattern& pattern = stiffness.pattern();
  const MassOperator& mass = dynamics.mass();
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int slot = pattern.row_begin(i); slot < pattern.row_end(i); ++slot) {
      if (pattern.column(slot) > i) break;
      add_block(i, pattern.column(slot), gamma * gamma * stiffness.block(i, slot));
      if (dynamics.has_damping())
        add_block(i, pattern.column(slot), gamma * damping.block(i, slot));
      if (!mass.is_diagonal() && pattern.column(slot) < i)
        add_block(i, pattern.column(slot), mass.at(i, slot) * Mat3::Identity());
    }
    const double own_mass = mass.at(i, pattern.diagonal_slot(i));
    for (int axis = 0; axis < 3; ++axis) entries.push_back({3 * i + axis, 3 * i + axis, own_mass});
  }
  if (dynamics.contact() != nullptr) {
    dynamics.contact()->visit_blocks(
        gamma, [&](int i, int j, const Mat3& block) { add_block(i, j, block); });
  }
  compress(3 * pattern.rows());
}

// Sorts the entries by column and row, and sums entries of equal column and row. The stable sort
// fixes the order of each sum, and so its bits.
void DirectSolver::Implementation::compress(int size) {
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::pair(a.column, a.row) < std::pair(b.column, b.row);
  });
  column_start.assign(size + 1, 0);
  row.clear();
  value.clear();
  const Entry* last = nullptr;
  for (const Entry& entry : entries) {
    if (last != nullptr && last->column == entry.column && last->row == entry.row) {
      value.back() += entry.value;
    } else {
      row.push_back(entry.row);
      value.push_back(entry.value);
      ++column_start[entry.column + 1];
    }
    last = &entry;
  }
  std::partial_sum(column_start.begin(), column_start.end(), column_start.begin());
}

DirectSolver::DirectSolver(Dynamics& dynamics)
    : implementation_(std::make_unique<Implementation>(dynamics)) {}
DirectSolver::~DirectSolver() = default;

bool DirectSolver::solve(double gamma, std::span<const Vec3> right_side, std::span<Vec3> velocity) {
  Implementation& self = *implementation_;
  self.assemble(gamma);
  const auto size = static_cast<Eigen::Index>(self.column_start.size()) - 1;
  const Eigen::Map<const Eigen::SparseMatrix<double>> matrix(
      size, size, static_cast<Eigen::Index>(self.value.size()), self.column_start.data(),
      self.row.data(), self.value.data());
  if (self.column_start != self.analysed_start || self.row != self.analysed_row) {
    self.factors.analyzePattern(matrix);
    self.analysed_start = self.column_start;
    self.analysed_row = self.row;
  }
  self.factors.factorize(matrix);
  if (self.factors.info() != Eigen::Success) return false;
  if (!(self.factors.vectorD().minCoeff() > 0)) return false;
  const Eigen::VectorXd solution =
      self.factors.solve(Eigen::Map<const Eigen::VectorXd>(right_side[0].data(), size));
  if (!solution.allFinite()) return false;
  Eigen::Map<Eigen::VectorXd>(velocity[0].data(), size) = solution;
  return true;
}

}  // namespace weft::sim
