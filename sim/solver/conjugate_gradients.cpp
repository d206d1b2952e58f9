#include "sim/solver/conjugate_gradients.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "materials/lanes.h"
#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

// Largest number of iterations. A system that needs more has not converged.
constexpr int most_iterations = 2000;

// Number of iterations between two questions whether to stop.
constexpr int iterations_per_question = 16;

// Largest allowed ratio of one particle's weighted residual to the root mean square that the bound
// implies. A bound on the mean alone would leave a few particles badly solved, and steps of
// microseconds would follow (docs/decisions/0005).
constexpr double peak_to_mean = 10;

// Fraction of the initial residual below which residuals are mostly rounding errors. There
// iterations end if the residual meets its bound, whatever the estimated error is.
constexpr double rounding = 1e-13;

// Assumed ratio of the true error to its estimate with block-Jacobi. There the error falls unevenly
// and sometimes stagnates, which makes the estimate too small.
constexpr double block_jacobi_doubt = 4;

using materials::Lanes;

// Number of particles whose entries are updated and then measured, while they are in the
// first-level cache.
constexpr int particles_at_once = 64;

// Adds factor * from to `to`, for particles `begin` to `end` - 1.
void add_scaled(double factor, std::span<const Vec3> from, int begin, int end, std::span<Vec3> to) {
  const double* const x = from[begin].data();
  double* const y = to[begin].data();
  for (int i = 0; i < 3 * (end - begin); ++i) y[i] += factor * x[i];
}

// Returns the 2-norm of weighted residuals or, if larger, the least 2-norm that permits the largest
// particle's residual (`peak_to_mean`).
double norm_with_peak(double sum, double largest, std::size_t count) {
  return std::sqrt(
      std::max(sum, largest * static_cast<double>(count) / (peak_to_mean * peak_to_mean)));
}

}  // namespace

ConjugateGradients::ConjugateGradients(const VelocityMatrix& matrix, MassOperator& mass,
                                       PreconditionerSelection& preconditioner)
    : matrix_(matrix),
      mass_(mass),
      preconditioner_(preconditioner),
      residual_(matrix.dynamics().particle_count()),
      preconditioned_(residual_.size()),
      direction_(residual_.size()),
      product_(residual_.size()) {
  for (const double each : matrix.scene().mass) inverse_mass_.push_back(1 / each);
}

ConjugateGradients::Outcome ConjugateGradients::solve(std::span<const Vec3> right_side,
                                                      std::span<const Vec3> weight,
                                                      const Goal& goal, std::span<Vec3> dv) {
  const Solve solve{right_side, weight, goal, dv};
  Outcome outcome;
  const int threads = matrix_.threads();
  if (goal.from_guess) {
    form_residual(solve);
  } else {
    parallel_set_zero(dv, threads);
    parallel_copy(right_side, residual_, threads);
  }
  // Clears the results of an earlier solve. They may not be finite, and advance() reads them even
  // for alpha = 0.
  parallel_set_zero(direction_, threads);
  parallel_set_zero(product_, threads);
  outcome.residual = start_residual_ = advance(0, solve);
  preconditioner_.start_solve(start_residual_);
  iterate(solve, outcome);
  if (goal.keeps_momentum && outcome.converged && outcome.iterations > 0) keep_momentum(solve);
  preconditioner_.finish_solve(outcome.iterations, outcome.residual);
  outcome.multigrid = preconditioner_.is_multigrid();
  outcome.multigrid_set_ups = preconditioner_.multigrid_set_ups();
  return outcome;
}

void ConjugateGradients::keep_momentum(const Solve& solve) {
  if (!translations_) translations_.emplace(matrix_);
  if (translations_->correct(residual_, direction_, product_)) advance(1, solve);
}

bool ConjugateGradients::should_stop(int iterations) const {
  return stop_ && iterations % iterations_per_question == 0 && stop_();
}

void ConjugateGradients::iterate(const Solve& solve, Outcome& outcome) {
  const Goal& goal = solve.goal;
  bool begins_anew = true;
  is_exact_ = matrix_.has_contact();
  has_single_products_ = false;
  gains_.clear();
  rho_ = 1;
  outcome.converged = is_reached(solve, outcome.residual);
  while (!outcome.converged && outcome.iterations < most_iterations) {
    outcome.stopped = should_stop(outcome.iterations);
    if (outcome.stopped) break;
    if (preconditioner_.rebuild_if_worn_out(outcome.iterations, outcome.residual)) {
      start_residual_ = outcome.residual;
      begins_anew = true;
    }
    const bool is_definite = find_direction(begins_anew);
    if (!is_definite && !has_single_products_) {
      outcome.indefinite = true;
      break;
    }
    if (is_definite) {
      outcome.residual = advance(rho_ / curvature_, solve);
      gains_.push_back(rho_ / curvature_ * rho_);
    }
    ++outcome.iterations;
    outcome.converged = is_reached(solve, outcome.residual);
    begins_anew = has_single_products_ && (!is_definite || outcome.converged);
    if (begins_anew) {
      is_exact_ = true;
      has_single_products_ = false;
      const double recursive_residual = outcome.residual;
      form_residual(solve);
      outcome.residual = advance(0, solve);
      outcome.converged = outcome.converged && is_small(solve, outcome.residual) &&
                          (goal.error >= 1 || outcome.residual <= 2 * recursive_residual);
    }
  }
}

// Computes z = P r, with the preconditioner P, and returns r . z.
double ConjugateGradients::precondition() {
  return preconditioner_.chosen().apply(matrix_, residual_, preconditioned_);
}

// Finds the next direction p and A p. The product is in single precision if the preconditioner
// provides it and the solve still accepts it. Returns false if p . A p is not positive.
bool ConjugateGradients::find_direction(bool begins_anew) {
  const int count = static_cast<int>(residual_.size()), threads = matrix_.threads();
  double next = precondition();
  if (!(next > 0) && preconditioner_.is_multigrid()) {
    // Rounding can make r . P r negative if the matrix is nearly singular.
    preconditioner_.give_up_multigrid();
    begins_anew = true;
    next = precondition();
  }
  const double beta = begins_anew ? 0 : next / rho_;
  const std::span<const Vec3> left =
      is_exact_ ? std::span<const Vec3>() : preconditioner_.chosen().residual();
  rho_ = next;
  has_single_products_ |= !left.empty();
  curvature_ = parallel_sum(count, threads, [&](int first, int last) {
    double sum = 0;
    for (int i = first; i < last; ++i) {
      direction_[i] = preconditioned_[i] + beta * direction_[i];
      if (left.empty()) continue;
      product_[i] = residual_[i] - left[i] + beta * product_[i];
      sum += direction_[i].dot(product_[i]);
    }
    return sum;
  });
  if (left.empty()) {
    matrix_.multiply(direction_, product_);
    curvature_ = dot(direction_, product_, threads);
  }
  return curvature_ > 0;
}

// Adds alpha p to dv and subtracts alpha A p from r. Returns norm_with_peak() of the weighted
// residual divided by Scene::mass.
double ConjugateGradients::advance(double alpha, const Solve& solve) {
  const int count = static_cast<int>(residual_.size());
  const auto parts =
      parallel_parts<Measure>(count, matrix_.threads(), [&](int first, int last, Measure& part) {
        for (int begin = first; begin < last; begin += particles_at_once) {
          const int end = std::min(begin + particles_at_once, last);
          add_scaled(alpha, direction_, begin, end, solve.dv);
          add_scaled(-alpha, product_, begin, end, residual_);
          measure(solve, begin, end, part);
        }
      });
  Measure all;
  for (const Measure& part : parts) {
    all.sum += part.sum;
    all.largest = std::max(all.largest, part.largest);
    all.dv += part.dv;
  }
  dv_square_ = all.dv;
  return norm_with_peak(all.sum, all.largest, residual_.size());
}

// Adds the measures of particles `begin` to `end` - 1.
void ConjugateGradients::measure(const Solve& solve, int begin, int end, Measure& part) const {
  int i = begin;
  Lanes sum = 0, largest = 0, dv_square = 0;
  for (; i + materials::lane_count <= end; i += materials::lane_count) {
    const auto r = materials::load_vectors(residual_[i].data());
    const auto weight = materials::load_vectors(solve.weight[i].data());
    const auto dv = materials::load_vectors(solve.dv[i].data());
    const Lanes inverse_mass = materials::lanes_at(&inverse_mass_[i]);
    const Lanes mass = materials::lanes_at(&matrix_.scene().mass[i]);
    Lanes square = 0, motion = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const Lanes share = inverse_mass * r[axis] * weight[axis];
      square += share * share;
      motion += dv[axis] * dv[axis];
    }
    sum += square;
    largest = materials::larger(square, largest);
    dv_square += mass * motion;
  }
  for (int lane = 0; lane < materials::lane_count; ++lane) {
    part.sum += sum.values[lane];
    part.largest = std::max(part.largest, largest.values[lane]);
    part.dv += dv_square.values[lane];
  }
  for (; i < end; ++i) {
    const double square =
        (inverse_mass_[i] * residual_[i]).cwiseProduct(solve.weight[i]).squaredNorm();
    part.sum += square;
    part.largest = std::max(part.largest, square);
    part.dv += matrix_.scene().mass[i] * solve.dv[i].squaredNorm();
  }
}

// Returns norm_with_peak() of the weighted M^-1 r, with the consistent mass of shells.
double ConjugateGradients::coupled_residual(const Solve& solve) {
  const std::span<Vec3> acceleration = preconditioned_;  // reused: precondition() fills it again
  std::copy(residual_.begin(), residual_.end(), acceleration.begin());
  mass_.solve(acceleration);
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < acceleration.size(); ++i) {
    const double square = acceleration[i].cwiseProduct(solve.weight[i]).squaredNorm();
    largest = std::max(largest, square);
    sum += square;
  }
  return norm_with_peak(sum, largest, acceleration.size());
}

// True if the residual meets the goal. `residual` is divided by row sums of M, which are up to a
// hundred times larger than its smallest eigenvalues. A consistent M therefore needs a second test,
// unless the residual is mostly rounding errors.
bool ConjugateGradients::is_small(const Solve& solve, double residual) {
  const double bound = solve.goal.residual;
  if (!(residual <= bound)) return false;
  return mass_.is_diagonal() || std::isinf(bound) || residual <= rounding * start_residual_ ||
         coupled_residual(solve) <= bound;
}

// Returns dv . M dv.
double ConjugateGradients::inertia(std::span<const Vec3> dv) const {
  return mass_.is_diagonal() ? dv_square_ : mass_.product(dv, dv, matrix_.threads());
}

// True if the residual and the estimated error meet the goal, or if the residual meets it and is
// mostly rounding errors. Each iteration lowers the squared error in the norm of A by its gain
// (Hestenes and Stiefel 1952, theorem 6:1). From dv = 0 the gains sum to dv . A dv. Two sums of
// gains extrapolate to the remaining error: over the last third of the iterations, and over the
// third before. Single gains fluctuate too much for this. The first four iterations are left out.
bool ConjugateGradients::is_reached(const Solve& solve, double residual) {
  const Goal& goal = solve.goal;
  if (!is_small(solve, residual)) return false;
  if (goal.error >= 1 || residual <= rounding * start_residual_) return true;
  const auto end = gains_.end();
  const auto window = std::max<std::ptrdiff_t>(1, (end - gains_.begin() - 4) / 3);
  if (end - gains_.begin() < 2 * window) return false;
  const double last = std::accumulate(end - window, end, 0.0);
  const double before = std::accumulate(end - 2 * window, end - window, 0.0);
  const double all = goal.scale == Goal::Scale::mass ? inertia(solve.dv)
                                                     : std::accumulate(gains_.begin(), end, 0.0);
  const double error =
      preconditioner_.is_multigrid() ? goal.error : goal.error / block_jacobi_doubt;
  return last < before && last * last / (before - last) <= error * error * all;
}

// Forms r = right_side - A dv in double.
void ConjugateGradients::form_residual(const Solve& solve) {
  matrix_.multiply(solve.dv, residual_);
  parallel_chunks(static_cast<int>(residual_.size()), matrix_.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) residual_[i] = solve.right_side[i] - residual_[i];
  });
}

}  // namespace weft::sim
