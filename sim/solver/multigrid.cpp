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

// Inverts blocks in place, zero for those that are left out; false where one is not positive
// definite.
template <class LeftOut>
bool invert_all(std::vector<Mat3>& blocks, int threads, const LeftOut& left_out) {
  const auto bad = parallel_sum(static_cast<int>(blocks.size()), threads, [&](int first, int last) {
    int count = 0;
    for (int i = first; i < last; ++i) {
      const Mat3 block = blocks[i];
      if (left_out(i)) {
        blocks[i].setZero();
      } else if (!invert_definite(block, blocks[i])) {
        ++count;
      }
    }
    return count;
  });
  return bad == 0;
}

}  // namespace

Multigrid::Level::Level(std::shared_ptr<const BlockPattern> pattern)
    : matrix(pattern), sweeps(*pattern), inverse_diagonal(pattern->rows()) {}

Multigrid::Multigrid(const Scene& scene, std::shared_ptr<const BlockPattern> pattern)
    : prolongations_(coarsen_images(scene)), residual_(pattern->rows()) {
  levels_.emplace_back(pattern);
  for (const Prolongation& prolongation : prolongations_) {
    pattern = galerkin_pattern(*pattern, prolongation);
    Level& level = levels_.emplace_back(pattern);
    level.b.resize(pattern->rows());
    level.x.resize(pattern->rows());
  }
}

bool Multigrid::set_up(const VelocityMatrix& matrix) {
  for (std::size_t i = 1; i < levels_.size(); ++i) {
    Level& level = levels_[i];
    galerkin_product(levels_[i - 1].matrix, prolongations_[i - 1], level.matrix, matrix.threads());
    if (i == 1 && matrix.has_contact()) add_contact(matrix);
    if (i + 1 == levels_.size()) break;
    const BlockPattern& pattern = level.matrix.pattern();
    for (int row = 0; row < pattern.rows(); ++row) {
      level.inverse_diagonal[row] = level.matrix.block(pattern.diagonal_slot(row)).cast<double>();
    }
    if (!invert_all(level.inverse_diagonal, matrix.threads(), [](int) { return false; }))
      return false;
  }
  return factor_coarsest();
}

// P^T E P of the contact part E. Couplings beyond the pattern, of surfaces that touch, are replaced
// by more on the diagonal: w_i w_j x_i.B x_j is at most the mean of |w_i w_j| x_i.B x_i and the
// same of j, so that nothing becomes indefinite.
void Multigrid::add_contact(const VelocityMatrix& matrix) {
  const Contact& contact = *matrix.dynamics().contact();
  SingleBlockMatrix& coarse = levels_[1].matrix;
  const BlockPattern& pattern = coarse.pattern();
  for (std::size_t pair = 0; pair < contact.pairs_in_reach(); ++pair) {
    const Contact::Coupling coupling = contact.definite_coupling(pair, matrix.gamma());
    const std::vector<CoarseWeight> weights = coarse_weights(coupling, prolongations_[0]);
    for (const CoarseWeight& a : weights) {
      for (const CoarseWeight& b : weights) {
        const double weight = a.weight * b.weight;
        const int slot = pattern.find_slot(a.node, b.node);
        if (slot >= 0) {
          coarse.block(slot) += (weight * coupling.block).cast<float>();
        } else {
          coarse.block(pattern.diagonal_slot(a.node)) +=
              (std::abs(weight) * coupling.block).cast<float>();
        }
      }
    }
  }
}

bool Multigrid::factor_coarsest() {
  const SingleBlockMatrix& matrix = levels_.back().matrix;
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
  Level& level = levels_.back();
  if (level.b.empty()) return;  // all particles are pinned
  const auto size = static_cast<Eigen::Index>(3 * level.b.size());
  Eigen::Map<Eigen::VectorXd>(level.x[0].data(), size) =
      cholesky_.solve(Eigen::Map<const Eigen::VectorXd>(level.b[0].data(), size));
}

bool Multigrid::update(const VelocityMatrix& matrix) {
  Level& finest = levels_.front();
  const BlockPattern& pattern = matrix.blocks().pattern();
  const int count = pattern.rows();
  if (version_ != matrix.version()) {
    version_ = matrix.version();
    const double* from = matrix.blocks().values().data();
    float* to = finest.matrix.values().data();
    parallel_chunks(count, matrix.threads(), [&](int first, int last) {
      const std::size_t end = 9 * static_cast<std::size_t>(pattern.row_end(last - 1));
      for (std::size_t i = 9 * static_cast<std::size_t>(pattern.row_begin(first)); i < end; ++i)
        to[i] = static_cast<float>(from[i]);
    });
  }
  std::vector<Mat3>& inverse = finest.inverse_diagonal;
  // Of what the sweeps read: the cycle is symmetric only if they agree to the last bit.
  parallel_chunks(count, matrix.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i)
      inverse[i] = finest.matrix.block(pattern.diagonal_slot(i)).cast<double>();
  });
  if (matrix.has_contact()) {
    // The sweeps leave contact out of their couplings. They reduce the energy of any error if twice
    // the diagonal exceeds A: |w_i| B does, as (sum w_i x_i).B(sum w_j x_j) is at most
    // sum |w_j| times sum |w_i| x_i.B x_i, and the weights' sizes sum to 2.
    const Contact& contact = *matrix.dynamics().contact();
    for (std::size_t pair = 0; pair < contact.pairs_in_reach(); ++pair) {
      const Contact::Coupling coupling = contact.definite_coupling(pair, matrix.gamma());
      for (int k = 0; k < 4; ++k) {
        if (coupling.nodes[k] < count)
          inverse[coupling.nodes[k]] += std::abs(coupling.weight[k]) * coupling.block;
      }
    }
  }
  const std::vector<char>& pinned = matrix.scene().pinned;
  return invert_all(inverse, matrix.threads(), [&](int i) { return pinned[i] != 0; });
}

// Adds to x of a level the correction of residual_ that the coarser ones find.
void Multigrid::correct(std::size_t i, std::span<Vec3> x, int threads) {
  const std::span<const Vec3> residual = std::span(residual_).first(x.size());
  prolongations_[i].restrict_to(residual, levels_[i + 1].b, threads);
  cycle(i + 1, threads);
  prolongations_[i].add_to(levels_[i + 1].x, x, threads);
}

void Multigrid::cycle(std::size_t i, int threads) {
  if (i + 1 == levels_.size()) {
    solve_coarsest();
    return;
  }
  Level& level = levels_[i];
  level.sweeps.solve_forward(level.matrix, level.inverse_diagonal, level.b, level.x, threads);
  level.sweeps.remaining(level.matrix, level.x, std::span(residual_).first(level.x.size()),
                         threads);
  correct(i, level.x, threads);
  level.sweeps.sweep_backward(level.matrix, level.inverse_diagonal, level.b, level.x, threads);
}

void Multigrid::apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) {
  const int threads = matrix.threads();
  const Level& finest = levels_.front();
  finest.sweeps.solve_forward(finest.matrix, finest.inverse_diagonal, r, z, threads);
  if (!matrix.has_contact()) {
    finest.sweeps.remaining(finest.matrix, z, residual_, threads);
    correct(0, z, threads);
    finest.sweeps.sweep_backward(finest.matrix, finest.inverse_diagonal, r, z, threads);
    return;
  }
  finest.matrix.multiply(z, residual_, threads);
  matrix.add_contact_product(z, residual_);
  for (std::size_t i = 0; i < residual_.size(); ++i) residual_[i] = r[i] - residual_[i];
  correct(0, z, threads);
  std::fill(residual_.begin(), residual_.end(), Vec3::Zero());
  matrix.add_contact_product(z, residual_);
  for (std::size_t i = 0; i < residual_.size(); ++i) residual_[i] = r[i] - residual_[i];
  finest.sweeps.sweep_backward(finest.matrix, finest.inverse_diagonal, residual_, z, threads);
}

}  // namespace weft::sim
