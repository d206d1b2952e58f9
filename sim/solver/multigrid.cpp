#include "sim/solver/multigrid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/parallel.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

// Returns the number of finest levels on which a second coarse cycle saves more time than it costs.
std::size_t best_w_cycle_levels(const Scene& scene, int particles) {
  const bool needs_w_cycles =
      particles >= 100'000 || traits_of(scene.source.time.method).finds_equilibria();
  return needs_w_cycles ? 2 : 0;
}

// Share of the trace of a diagonal block that is added to the block's diagonal in systems with
// contact. The rounding of stiff pairs to single precision changes the eigenvalues of their blocks
// by less: by 0.4, 1.2 and 3.3 units of epsilon times the trace where 1, 16 and 128 of them share a
// vertex, as measured.
constexpr float rounding_share = 4 * std::numeric_limits<float>::epsilon();

// The finest pattern may exceed the one that the present pairs need by this factor.
constexpr double most_growth = 1.5;

// Calls visit(a, b) for all pairs of dynamic particles that contact pairs in reach couple.
template <class Visit>
void visit_couplings(const BlockPattern& pattern, const Contact& contact, const Visit& visit) {
  const int count = pattern.rows();
  contact.visit_definite_couplings(0, [&](const Contact::Coupling& coupling) {
    for (const int a : coupling.particles) {
      for (const int b : coupling.particles) {
        if (a < count && b < count) visit(a, b);
      }
    }
  });
}

bool contains_pairs(const BlockPattern& pattern, const Contact& contact) {
  bool contains = true;
  visit_couplings(pattern, contact, [&](int a, int b) {
    contains = contains && (a == b || pattern.find_slot(a, b) >= 0);
  });
  return contains;
}

std::vector<std::vector<int>> neighbours_of(const BlockPattern& pattern) {
  std::vector<std::vector<int>> neighbours(pattern.rows());
  for (int row = 0; row < pattern.rows(); ++row) {
    for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot)
      neighbours[row].push_back(pattern.column(slot));
  }
  return neighbours;
}

// Returns the pattern extended by the couplings of contact pairs in reach.
std::shared_ptr<const BlockPattern> with_pairs(const BlockPattern& pattern,
                                               const Contact& contact) {
  std::vector<std::vector<int>> neighbours = neighbours_of(pattern);
  visit_couplings(pattern, contact, [&](int a, int b) { neighbours[a].push_back(b); });
  return std::make_shared<const BlockPattern>(neighbours);
}

void add_pairs(const Contact& contact, double gamma, SingleBlockMatrix& matrix) {
  const BlockPattern& pattern = matrix.pattern();
  contact.visit_definite_couplings(gamma, [&](const Contact::Coupling& coupling) {
    for (std::size_t i = 0; i < coupling.particles.size(); ++i) {
      for (std::size_t j = 0; j < coupling.particles.size(); ++j) {
        const int row = coupling.particles[i], column = coupling.particles[j];
        if (column < row || column >= pattern.rows()) continue;
        matrix.upper_block(pattern.upper(row, pattern.slot(row, column))) +=
            (coupling.weights[i] * coupling.weights[j] * coupling.block).cast<float>();
      }
    }
  });
}

// Makes diagonal blocks positive definite that lost this when stiff contact pairs were rounded to
// single precision. Along the surfaces of a pair, only stiffness and mass resist, and these may be
// smaller than the rounding error.
void cover_rounding(SingleBlockMatrix& matrix) {
  for (int i = 0; i < matrix.pattern().rows(); ++i) {
    auto block = matrix.upper_block(matrix.pattern().upper_diagonal(i));
    block.diagonal().array() += rounding_share * block.trace();
  }
}

// Inverts the diagonal blocks. Rows for which `left_out` is true get zero instead of an inverse.
// Returns false if a block is not positive definite.
template <class LeftOut>
bool invert_diagonal(const SingleBlockMatrix& matrix, int threads, const LeftOut& left_out,
                     std::vector<Mat3>& inverse) {
  const BlockPattern& pattern = matrix.pattern();
  const double bad = parallel_sum(pattern.rows(), threads, [&](int first, int last) {
    int count = 0;
    for (int i = first; i < last; ++i) {
      if (left_out(i)) {
        inverse[i].setZero();
      } else if (!invert_definite(matrix.diagonal_block(i).cast<double>(), inverse[i])) {
        ++count;
      }
    }
    return count;
  });
  return bad == 0;
}

}  // namespace

Multigrid::Level::Level(const std::shared_ptr<const BlockPattern>& pattern)
    : matrix(pattern), sweeps(*pattern), inverse_diagonal(pattern->rows()) {}

Multigrid::Multigrid(const Scene& scene, const std::shared_ptr<const BlockPattern>& pattern)
    : Multigrid(scene, pattern, best_w_cycle_levels(scene, pattern->rows())) {}

Multigrid::Multigrid(const Scene& scene, std::shared_ptr<const BlockPattern> pattern,
                     std::size_t w_cycle_levels)
    : pattern_(std::move(pattern)),
      prolongations_(coarsen_images(scene)),
      residual_(pattern_->rows()),
      change_(pattern_->rows()),
      w_cycle_levels_(w_cycle_levels) {
  find_patterns(pattern_);
}

void Multigrid::find_patterns(std::shared_ptr<const BlockPattern> finest) {
  levels_.clear();
  products_.clear();
  levels_.emplace_back(finest);
  for (const Prolongation& prolongation : prolongations_) {
    finest = products_.emplace_back(finest, prolongation).pattern();
    Level& level = levels_.emplace_back(finest);
    level.b.resize(finest->rows());
    level.x.resize(finest->rows());
  }
  analysed_ = false;
}

// Inverts the diagonal blocks of the finest matrix. Returns false if one of them is not positive
// definite.
bool Multigrid::invert_finest(const VelocityMatrix& matrix) {
  Level& finest = levels_.front();
  const std::vector<char>& pinned = matrix.scene().pinned;
  return invert_diagonal(
      finest.matrix, matrix.threads(), [&](int i) { return pinned[i] != 0; },
      finest.inverse_diagonal);
}

// Copies A to the finest level, with the contact pairs if `with_contact_`, and inverts its diagonal
// blocks. Returns false if a diagonal block is not positive definite.
bool Multigrid::take_finest(const VelocityMatrix& matrix) {
  version_ = matrix.version();
  Level& finest = levels_.front();
  matrix.copy_to(finest.matrix);
  if (with_contact_) {
    add_pairs(*matrix.dynamics().contact(), matrix.gamma(), finest.matrix);
    cover_rounding(finest.matrix);
  }
  return invert_finest(matrix);
}

// Makes patterns that contain all couplings of the matrix.
void Multigrid::choose_patterns(const VelocityMatrix& matrix) {
  with_contact_ = matrix.has_contact();
  const std::shared_ptr<const BlockPattern>& present = levels_.front().matrix.shared_pattern();
  if (!with_contact_) {
    if (present != pattern_) find_patterns(pattern_);
    return;
  }
  const Contact& contact = *matrix.dynamics().contact();
  if (contains_pairs(*present, contact)) return;
  auto needed = with_pairs(*pattern_, contact);
  if (present != pattern_) {
    auto grown = with_pairs(*present, contact);
    if (grown->block_count() <= most_growth * needed->block_count()) needed = std::move(grown);
  }
  find_patterns(std::move(needed));
}

void Multigrid::transfer_patterns(StateArchive& archive) {
  const BlockPattern& present = levels_.front().matrix.pattern();
  std::vector<int> more;  // row and column of each coupling above the diagonal
  for (int row = 0; row < present.rows() && &present != pattern_.get(); ++row) {
    for (int slot = present.diagonal_slot(row) + 1; slot < present.row_end(row); ++slot) {
      const int column = present.column(slot);
      if (pattern_->find_slot(row, column) < 0) more.insert(more.end(), {row, column});
    }
  }
  archive(more);
  if (!archive.reads()) return;
  if (more.empty()) {
    if (&present != pattern_.get()) find_patterns(pattern_);
    return;
  }
  std::vector<std::vector<int>> neighbours = neighbours_of(*pattern_);
  for (std::size_t i = 0; i < more.size(); i += 2) {
    neighbours[more[i]].push_back(more[i + 1]);
    neighbours[more[i + 1]].push_back(more[i]);
  }
  find_patterns(std::make_shared<const BlockPattern>(neighbours));
}

bool Multigrid::transfer_finest(StateArchive& archive, const VelocityMatrix& matrix) {
  SingleBlockMatrix& finest = levels_.front().matrix;
  for (int i = 0; i < finest.pattern().upper_count(); ++i) {
    float* const entries = finest.upper_block(i).data();
    for (int k = 0; k < 9; ++k) archive(entries[k]);
  }
  if (!archive.reads()) return true;
  with_contact_ = true;
  return invert_finest(matrix) && form_coarse(matrix.threads());
}

bool Multigrid::set_up(const VelocityMatrix& matrix) {
  choose_patterns(matrix);
  return take_finest(matrix) && form_coarse(matrix.threads());
}

// Forms the matrices of the coarser levels. Returns false if a diagonal block or the coarsest
// matrix is not positive definite.
bool Multigrid::form_coarse(int threads) {
  for (std::size_t i = 1; i < levels_.size(); ++i) {
    Level& level = levels_[i];
    products_[i - 1].form(levels_[i - 1].matrix, level.matrix, threads);
    if (i + 1 < levels_.size() &&
        !invert_diagonal(
            level.matrix, threads, [](int) { return false; }, level.inverse_diagonal))
      return false;
  }
  return factor_coarsest();
}

bool Multigrid::update(const VelocityMatrix& matrix) {
  return with_contact_ || version_ == matrix.version() || take_finest(matrix);
}

bool Multigrid::factor_coarsest() {
  const SingleBlockMatrix& matrix = levels_.back().matrix;
  const BlockPattern& pattern = matrix.pattern();
  if (pattern.rows() == 0) return true;  // all particles are pinned
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(9 * static_cast<std::size_t>(pattern.block_count()));
  for (int row = 0; row < pattern.rows(); ++row) {
    for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot) {
      const SingleBlockMatrix::Block block = matrix.block(row, slot);
      for (int i = 0; i < 9; ++i) {
        entries.emplace_back(3 * row + i % 3, 3 * pattern.column(slot) + i / 3,
                             block(i % 3, i / 3));
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

// Sweeps forward from x = 0, then adds the correction of the next coarser level. That level is
// solved directly if it is the coarsest, otherwise by one or two cycles. The second cycle starts
// from the residual of the first.
void Multigrid::correct(std::size_t i, std::span<const Vec3> b, std::span<Vec3> x, int threads) {
  const Level& level = levels_[i];
  Level& coarser = levels_[i + 1];
  const std::span<Vec3> residual = std::span(residual_).first(x.size());
  level.sweeps.solve_forward(level.matrix, level.inverse_diagonal, b, x, threads);
  level.sweeps.find_residual(GaussSeidel::Half::upper, level.matrix, x, residual, threads);
  prolongations_[i].restrict_to(residual, coarser.b, threads);
  if (i + 2 == levels_.size()) {
    solve_coarsest();
    prolongations_[i].add_to(coarser.x, x, threads);
    return;
  }
  cycle(i + 1, coarser.b, coarser.x, threads);
  prolongations_[i].add_to(coarser.x, x, threads);
  if (i >= w_cycle_levels_) return;
  find_residual(i + 1, coarser.b, threads);
  cycle(i + 1, coarser.b, coarser.x, threads);
  prolongations_[i].add_to(coarser.x, x, threads);
}

void Multigrid::cycle(std::size_t i, std::span<const Vec3> b, std::span<Vec3> x, int threads) {
  correct(i, b, x, threads);
  const Level& level = levels_[i];
  level.sweeps.sweep_backward(level.matrix, level.inverse_diagonal, b, x,
                              std::span(change_).first(x.size()), threads);
}

// Computes the residual after cycle(i) from the change of x in its backward sweep.
void Multigrid::find_residual(std::size_t i, std::span<Vec3> residual, int threads) {
  const Level& level = levels_[i];
  level.sweeps.find_residual(GaussSeidel::Half::lower, level.matrix,
                             std::span(change_).first(residual.size()), residual, threads);
}

double Multigrid::apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) {
  cycle(0, r, z, matrix.threads());
  find_residual(0, residual_, matrix.threads());
  matrix.clear_pinned(residual_);
  return dot(r, z, matrix.threads());
}

}  // namespace weft::sim
