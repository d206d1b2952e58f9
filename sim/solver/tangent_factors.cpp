#include "sim/solver/tangent_factors.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace weft::sim {

namespace {

using Matrix = Eigen::SparseMatrix<double>;

// Smallest pivot, as a fraction of its diagonal entry, that is told from rounding.
constexpr double smallest_pivot = 1e-15;
// Largest residual of a solution, as a fraction of the right-hand side. Where K is singular but for
// rounding, the residual is of the order of the right-hand side itself.
constexpr double largest_residual = 1e-2;

}  // namespace

struct TangentFactors::Implementation {
  explicit Implementation(Dynamics& dynamics_) : dynamics(dynamics_) {
    number.assign(dynamics.particle_count(), -1);
    for (int i = 0; i < dynamics.particle_count(); ++i) {
      if (dynamics.scene().pinned[i] != 0) continue;
      number[i] = static_cast<int>(free.size());
      free.push_back(i);
    }
  }
  void assemble();
  void add_block(int row, int column, const Mat3& block);
  bool has_new_pattern() const;
  bool judge_pivots();
  void find_softest();

  Dynamics& dynamics;
  std::vector<int> free, number;  // free particles; the number of a particle among them, or -1
  std::vector<Eigen::Triplet<double>> entries;  // of the lower half; sums where there are several
  Matrix matrix;
  std::vector<int> analysed_start, analysed_row;
  Eigen::SimplicialLDLT<Matrix> factors;
  int negative = 0, weakest = -1;
  std::int64_t count = 0;
};

void TangentFactors::Implementation::add_block(int row, int column, const Mat3& block) {
  const int first = number[row], second = number[column];
  if (first < 0 || second < 0) return;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      if (3 * first + i >= 3 * second + j)
        entries.emplace_back(3 * first + i, 3 * second + j, block(i, j));
    }
  }
}

void TangentFactors::Implementation::assemble() {
  entries.clear();
  const BlockMatrix& stiffness = dynamics.stiffness();
  const BlockPattern& pattern = stiffness.pattern();
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int slot = pattern.row_begin(i); slot <= pattern.diagonal_slot(i); ++slot)
      add_block(i, pattern.column(slot), stiffness.block(i, slot));
  }
  if (dynamics.contact() != nullptr) {
    dynamics.contact()->visit_blocks(
        1, [&](int i, int j, const Mat3& block) { add_block(i, j, block); });
  }
  const auto size = static_cast<Eigen::Index>(3 * free.size());
  matrix.resize(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
}

bool TangentFactors::Implementation::has_new_pattern() const {
  const auto columns = static_cast<std::size_t>(matrix.outerSize()) + 1;
  const auto rows = static_cast<std::size_t>(matrix.nonZeros());
  return analysed_start.size() != columns || analysed_row.size() != rows ||
         !std::equal(analysed_start.begin(), analysed_start.end(), matrix.outerIndexPtr()) ||
         !std::equal(analysed_row.begin(), analysed_row.end(), matrix.innerIndexPtr());
}

// Counts the negative pivots and finds the weakest one. Returns false if that is lost in rounding.
bool TangentFactors::Implementation::judge_pivots() {
  const auto& order = factors.permutationP().indices();
  const auto pivots = factors.vectorD();
  const Eigen::VectorXd diagonal = matrix.diagonal();
  negative = 0;
  weakest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    const double pivot = pivots[order.size() == 0 ? i : order[i]];
    if (pivot < 0) ++negative;
    const double share = std::abs(pivot / diagonal[i]);
    // The comparison also finds a share that is not a number.
    if (share >= least) continue;
    least = std::isfinite(share) ? share : 0;
    weakest = free[static_cast<std::size_t>(i / 3)];
  }
  return least > smallest_pivot;
}

// Names the particle with the smallest entry on the diagonal, where there are no pivots.
void TangentFactors::Implementation::find_softest() {
  const Eigen::VectorXd diagonal = matrix.diagonal();
  Eigen::Index softest = 0;
  diagonal.cwiseAbs().minCoeff(&softest);
  weakest = free[static_cast<std::size_t>(softest / 3)];
}

TangentFactors::TangentFactors(Dynamics& dynamics)
    : implementation_(std::make_unique<Implementation>(dynamics)) {}
TangentFactors::~TangentFactors() = default;

bool TangentFactors::factorise() {
  Implementation& self = *implementation_;
  ++self.count;
  self.assemble();
  if (self.has_new_pattern()) {
    self.factors.analyzePattern(self.matrix);
    const int* const start = self.matrix.outerIndexPtr();
    const int* const row = self.matrix.innerIndexPtr();
    self.analysed_start.assign(start, start + self.matrix.outerSize() + 1);
    self.analysed_row.assign(row, row + self.matrix.nonZeros());
  }
  if (self.free.empty()) return true;
  self.factors.factorize(self.matrix);
  if (self.factors.info() == Eigen::Success) return self.judge_pivots();
  self.find_softest();
  return false;
}

int TangentFactors::negative_directions() const { return implementation_->negative; }
int TangentFactors::weakest_particle() const { return implementation_->weakest; }
std::int64_t TangentFactors::factorisations() const { return implementation_->count; }

bool TangentFactors::solve(std::span<const Vec3> force, std::span<Vec3> displacement) const {
  const Implementation& self = *implementation_;
  std::ranges::fill(displacement, Vec3(Vec3::Zero()));
  if (self.free.empty()) return true;
  Eigen::VectorXd right(static_cast<Eigen::Index>(3 * self.free.size()));
  for (std::size_t i = 0; i < self.free.size(); ++i)
    right.segment<3>(static_cast<Eigen::Index>(3 * i)) = force[self.free[i]];
  const Eigen::VectorXd result = self.factors.solve(right);
  if (!result.allFinite()) return false;
  const Eigen::VectorXd product = self.matrix.selfadjointView<Eigen::Lower>() * result;
  if ((product - right).norm() > largest_residual * right.norm()) return false;
  for (std::size_t i = 0; i < self.free.size(); ++i)
    displacement[self.free[i]] = result.segment<3>(static_cast<Eigen::Index>(3 * i));
  return true;
}

}  // namespace weft::sim
