#include "sim/solver/multigrid.h"

#include <algorithm>
#include <cmath>

#include "sim/parallel.h"

namespace weft::sim {

namespace {

// What a contact pair weighs on the nodes of a coarse level.
struct CoarseWeight {
  int node = 0;
  double weight = 0;
};

std::vector<CoarseWeight> coarse_weights(const Contact::Coupling& coupling,
                                         const Prolongation& prolongation) {
  std::vector<CoarseWeight> result;
  for (int i = 0; i < 4; ++i) {
    const int node = coupling.nodes[i];
    if (node >= prolongation.fine_count()) continue;  // of an obstacle
    for (int k = prolongation.row_start[node]; k < prolongation.row_start[node + 1]; ++k) {
      const double weight = coupling.weight[i] * prolongation.weight[k];
      const auto same = std::find_if(result.begin(), result.end(), [&](const CoarseWeight& known) {
        return known.node == prolongation.column[k];
      });
      if (same != result.end()) {
        same->weight += weight;
      } else {
        result.push_back({prolongation.column[k], weight});
      }
    }
  }
  return result;
}

}  // namespace

Multigrid::Level::Level(Prolongation from_coarse, std::shared_ptr<const BlockPattern> pattern)
    : prolongation(std::move(from_coarse)),
      matrix(pattern),
      sweeps(*pattern),
      inverse_diagonal(pattern->rows()),
      b(pattern->rows()),
      x(pattern->rows()),
      residual(pattern->rows()) {}

Multigrid::Multigrid(const Scene& scene, const BlockPattern& pattern)
    : sweeps_(pattern), inverse_diagonal_(pattern.rows()), residual_(pattern.rows()) {
  const BlockPattern* finer = &pattern;
  for (Prolongation& prolongation : coarsen_images(scene)) {
    auto coarse = galerkin_pattern(*finer, prolongation);
    coarse_.emplace_back(std::move(prolongation), std::move(coarse));
    finer = &coarse_.back().matrix.pattern();
  }
}

bool Multigrid::set_up(const VelocityMatrix& matrix) {
  const int threads = matrix.threads();
  for (std::size_t i = 0; i < coarse_.size(); ++i) {
    Level& level = coarse_[i];
    if (i == 0) {
      galerkin_product(matrix.blocks(), level.prolongation, level.matrix, threads);
      if (matrix.has_contact()) add_contact(matrix, level);
    } else {
      galerkin_product(coarse_[i - 1].matrix, level.prolongation, level.matrix, threads);
    }
    if (i + 1 == coarse_.size()) break;
    for (std::size_t row = 0; row < level.inverse_diagonal.size(); ++row) {
      const int slot = level.matrix.pattern().diagonal_slot(static_cast<int>(row));
      if (!invert_definite(level.matrix.block(slot).cast<double>(), level.inverse_diagonal[row]))
        return false;
    }
  }
  return factor_coarsest();
}

// P^T E P of the contact part E. Couplings beyond the pattern, of surfaces that touch, are replaced
// by more on the diagonal: w_i w_j x_i.B x_j is at most the mean of |w_i w_j| x_i.B x_i and the
// same of j, so that nothing becomes indefinite.
void Multigrid::add_contact(const VelocityMatrix& matrix, Level& level) const {
  const Contact& contact = *matrix.dynamics().contact();
  const BlockPattern& pattern = level.matrix.pattern();
  for (std::size_t pair = 0; pair < contact.pairs_in_reach(); ++pair) {
    const Contact::Coupling coupling = contact.definite_coupling(pair, matrix.gamma());
    const std::vector<CoarseWeight> weights = coarse_weights(coupling, level.prolongation);
    for (const CoarseWeight& a : weights) {
      for (const CoarseWeight& b : weights) {
        const double weight = a.weight * b.weight;
        const int slot = pattern.find_slot(a.node, b.node);
        if (slot >= 0) {
          level.matrix.block(slot) += (weight * coupling.block).cast<float>();
        } else {
          level.matrix.block(pattern.diagonal_slot(a.node)) +=
              (std::abs(weight) * coupling.block).cast<float>();
        }
      }
    }
  }
}

bool Multigrid::factor_coarsest() {
  const CoarseMatrix& matrix = coarse_.back().matrix;
  const BlockPattern& pattern = matrix.pattern();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(matrix.values().size());
  for (int row = 0; row < pattern.rows(); ++row) {
    for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot) {
      for (int i = 0; i < 9; ++i) {
        entries.emplace_back(3 * row + i % 3, 3 * pattern.column(slot) + i / 3,
                             matrix.block(slot)(i % 3, i / 3));
      }
    }
  }
  coarsest_.resize(3 * pattern.rows(), 3 * pattern.rows());
  coarsest_.setFromTriplets(entries.begin(), entries.end());
  if (!analysed_) cholesky_.analyzePattern(coarsest_);
  analysed_ = true;
  cholesky_.factorize(coarsest_);
  return cholesky_.info() == Eigen::Success;
}

void Multigrid::solve_coarsest() {
  Level& level = coarse_.back();
  if (level.b.empty()) return;  // all particles are pinned
  const auto size = static_cast<Eigen::Index>(3 * level.b.size());
  Eigen::Map<Eigen::VectorXd>(level.x[0].data(), size) =
      cholesky_.solve(Eigen::Map<const Eigen::VectorXd>(level.b[0].data(), size));
}

bool Multigrid::update(const VelocityMatrix& matrix) {
  const BlockPattern& pattern = matrix.blocks().pattern();
  for (int i = 0; i < pattern.rows(); ++i)
    inverse_diagonal_[i] = matrix.blocks().block(pattern.diagonal_slot(i));
  if (matrix.has_contact()) {
    // The sweeps leave contact out of their couplings. They reduce the energy of any error if twice
    // the diagonal exceeds A: |w_i| B does, as (sum w_i x_i).B(sum w_j x_j) is at most
    // sum |w_j| times sum |w_i| x_i.B x_i, and the weights' sizes sum to 2.
    const Contact& contact = *matrix.dynamics().contact();
    for (std::size_t pair = 0; pair < contact.pairs_in_reach(); ++pair) {
      const Contact::Coupling coupling = contact.definite_coupling(pair, matrix.gamma());
      for (int k = 0; k < 4; ++k) {
        if (coupling.nodes[k] < pattern.rows())
          inverse_diagonal_[coupling.nodes[k]] += std::abs(coupling.weight[k]) * coupling.block;
      }
    }
  }
  const std::vector<char>& pinned = matrix.scene().pinned;
  for (int i = 0; i < pattern.rows(); ++i) {
    const Mat3 block = inverse_diagonal_[i];
    if (pinned[i] != 0) {
      inverse_diagonal_[i].setZero();
    } else if (!invert_definite(block, inverse_diagonal_[i])) {
      return false;
    }
  }
  return true;
}

// x of the level before += P (correction of its residual).
void Multigrid::cycle(std::size_t i, int threads) {
  if (i + 1 == coarse_.size()) {
    solve_coarsest();
    return;
  }
  Level& level = coarse_[i];
  Level& coarser = coarse_[i + 1];
  level.sweeps.solve_forward(level.matrix, level.inverse_diagonal, level.b, level.x, threads);
  level.sweeps.remaining(level.matrix, level.x, level.residual, threads);
  coarser.prolongation.restrict_to(level.residual, coarser.b, threads);
  cycle(i + 1, threads);
  coarser.prolongation.add_to(coarser.x, level.x, threads);
  level.sweeps.sweep_backward(level.matrix, level.inverse_diagonal, level.b, level.x, threads);
}

void Multigrid::apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) {
  const int threads = matrix.threads();
  const BlockMatrix& blocks = matrix.blocks();
  const bool contact = matrix.has_contact();
  Level& coarse = coarse_.front();
  sweeps_.solve_forward(blocks, inverse_diagonal_, r, z, threads);
  if (contact) {
    matrix.multiply(z, residual_);
    for (std::size_t i = 0; i < residual_.size(); ++i) residual_[i] = r[i] - residual_[i];
  } else {
    sweeps_.remaining(blocks, z, residual_, threads);
  }
  coarse.prolongation.restrict_to(residual_, coarse.b, threads);
  cycle(0, threads);
  coarse.prolongation.add_to(coarse.x, z, threads);
  if (!contact) {
    sweeps_.sweep_backward(blocks, inverse_diagonal_, r, z, threads);
    return;
  }
  std::fill(residual_.begin(), residual_.end(), Vec3::Zero());
  matrix.add_contact_product(z, residual_);
  for (std::size_t i = 0; i < residual_.size(); ++i) residual_[i] = r[i] - residual_[i];
  sweeps_.sweep_backward(blocks, inverse_diagonal_, residual_, z, threads);
}

}  // namespace weft::sim
