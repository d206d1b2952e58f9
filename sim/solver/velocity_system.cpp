#include "sim/solver/velocity_system.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

// Limit of conjugate gradient iterations. If the residual is still too large, conjugate gradients
// cannot handle the matrix: the caller is told, and cuts the step.
constexpr int largest_iteration_count = 2000;

// Largest ratio of a particle's residual to the mean. A bound on the mean over thousands of
// particles alone would leave a few of them hardly solved. Where stiff friction holds these, they
// then swing from step to step, and the error control answers with endless steps of microseconds.
constexpr double peak_to_mean = 10;

// Multigrid is faster than block-Jacobi above this value of gamma times the highest frequency
// (docs/benchmarks.md).
constexpr double multigrid_break_even = 6;

// The cost of forming the coarse matrices, in iterations.
constexpr double set_up_iterations = 2;

// After coarse matrices have worn out within a solve, new ones are formed at once for this many
// assemblies of K. Then older ones are tried again.
constexpr int assemblies_to_renew = 10;

// The largest eigenvalue of K hardly changes. It is estimated once in this many assemblies, by
// `power_steps` steps of the power method.
constexpr std::int64_t assemblies_a_frequency = 100;
constexpr int power_steps = 10;

// Fraction of the initial residual below which rounding leaves nothing to gain.
constexpr double rounding = 1e-13;

// Ratio of the true error to the estimated one that block-Jacobi may reach: its gains swing and
// stand still.
constexpr double block_jacobi_doubt = 4;

// Number of factorised systems before iterations are tried again, at first and at most. A few hard
// systems, as where surfaces meet, say nothing about those that follow.
constexpr int first_factorisations = 8, most_factorisations = 4096;

// Returns the number of iterations that take as long as a factorisation. On a surface, the cost of
// a factorisation grows with the power 1.5 of the number of particles. Above some 150 000
// particles, the result exceeds `largest_iteration_count`.
double worth_a_factorisation(int particles) { return 40 + 5 * std::sqrt(particles); }

double dot(std::span<const Vec3> a, std::span<const Vec3> b, int threads) {
  return parallel_sum(static_cast<int>(a.size()), threads, [&](int first, int last) {
    double sum = 0;
    for (int i = first; i < last; ++i) sum += a[i].dot(b[i]);
    return sum;
  });
}

}  // namespace

VelocitySystem::VelocitySystem(Dynamics& dynamics)
    : dynamics_(dynamics),
      matrix_(dynamics),
      right_side_(dynamics.particle_count()),
      residual_(dynamics.particle_count()),
      direction_(dynamics.particle_count()),
      product_(dynamics.particle_count()),
      preconditioned_(dynamics.particle_count()) {}

void VelocitySystem::set_up(double gamma) { matrix_.form(gamma); }

// Takes steps of the power method from a random vector.
double VelocitySystem::highest_frequency() {
  const std::int64_t assemblies = dynamics_.statistics().counters.matrix_assemblies;
  if (frequency_ >= 0 && assemblies < frequency_assembly_ + assemblies_a_frequency)
    return frequency_;
  frequency_assembly_ = assemblies;
  const Scene& scene = dynamics_.scene();
  const int count = dynamics_.particle_count(), threads = dynamics_.threads();
  std::uint32_t random = 1;
  for (Vec3& v : direction_) {
    for (double& component : v) {
      random = 1664525 * random + 1013904223;
      component = random / 4294967296.0 - 0.5;
    }
  }
  double square = 0;
  for (int step = 0; step < power_steps; ++step) {
    for (int i = 0; i < count; ++i) {
      if (scene.pinned[i] != 0) direction_[i].setZero();
    }
    const double size = std::sqrt(dot(direction_, direction_, threads));
    if (!(size > 0)) break;
    for (Vec3& v : direction_) v /= size;
    dynamics_.stiffness().multiply(direction_, product_, threads);
    for (int i = 0; i < count; ++i) product_[i] /= scene.mass[i];
    square = dot(direction_, product_, threads);
    direction_.swap(product_);
  }
  frequency_ = std::sqrt(std::max(0.0, square));
  return frequency_;
}

bool VelocitySystem::wants_multigrid() {
  switch (dynamics_.scene().source.time.preconditioner) {
    case PreconditionerChoice::block_jacobi:
      return false;
    case PreconditionerChoice::multigrid:
      return true;
    case PreconditionerChoice::automatic:
      break;
  }
  return matrix_.gamma() * highest_frequency() > multigrid_break_even;
}

bool VelocitySystem::set_up_multigrid(Outcome& outcome) {
  ++outcome.multigrid_set_ups;
  iterations_a_digit_ = excess_iterations_ = 0;
  set_up_assembly_ = dynamics_.statistics().counters.matrix_assemblies;
  set_up_place_ = dynamics_.linearisation();
  set_up_gamma_ = matrix_.gamma();
  is_set_up_ = multigrid_->set_up(matrix_);
  return is_set_up_;
}

void VelocitySystem::transfer(StateArchive& archive) {
  Linearisation& place = set_up_place_;
  archive(factorised_from_, factorisation_patience_, factorisations_left_, hard_gamma_, is_set_up_,
          iterations_a_digit_, excess_iterations_, set_up_assembly_, renewed_until_, frequency_,
          frequency_assembly_, set_up_gamma_, place.time, place.step_start, place.state,
          place.definiteness, place.gamma, place.load, place.hardness);
  if (!archive.reads() || !is_set_up_) return;
  dynamics_.assemble_again(place);
  matrix_.form(set_up_gamma_);
  if (multigrid_ == nullptr)
    multigrid_ = std::make_unique<Multigrid>(dynamics_.scene(), matrix_.pattern());
  is_set_up_ = multigrid_->set_up(matrix_);
  dynamics_.set_hardness(1);
}

// Chooses the preconditioner of this solve and brings it up to date.
void VelocitySystem::prepare(Outcome& outcome) {
  if (wants_multigrid()) {
    if (multigrid_ == nullptr)
      multigrid_ = std::make_unique<Multigrid>(dynamics_.scene(), matrix_.pattern());
    const std::int64_t assembly = dynamics_.statistics().counters.matrix_assemblies;
    const bool is_worn = !is_set_up_ || excess_iterations_ > set_up_iterations ||
                         (assembly != set_up_assembly_ && assembly < renewed_until_);
    if (is_worn ? set_up_multigrid(outcome) : multigrid_->update(matrix_)) {
      preconditioner_ = multigrid_.get();
      return;
    }
  }
  use_block_jacobi();
}

void VelocitySystem::use_block_jacobi() {
  preconditioner_ = &block_jacobi_;
  static_cast<void>(block_jacobi_.update(matrix_));  // always possible
}

double VelocitySystem::precondition() {
  preconditioner_->apply(matrix_, residual_, preconditioned_);
  return dot(residual_, preconditioned_, dynamics_.threads());
}

// Does dv += alpha p and r -= alpha A p. Returns the 2-norm of the weighted residual, or the norm
// whose mean is 1 / `peak_to_mean` of the largest particle's, if that is larger.
double VelocitySystem::advance(double alpha, std::span<const Vec3> weight, Vec3* dv) {
  struct Part {
    double sum = 0, largest = 0, dv = 0;
  };
  const std::vector<double>& mass = dynamics_.scene().mass;
  const int count = static_cast<int>(residual_.size());
  std::vector<Part> parts((count + chunk_size - 1) / chunk_size);
  parallel_chunks(count, dynamics_.threads(), [&](int first, int last) {
    Part part;
    for (int i = first; i < last; ++i) {
      dv[i] += alpha * direction_[i];
      residual_[i] -= alpha * product_[i];
      const double square =
          residual_[i].cwiseProduct(weight[i]).squaredNorm() / (mass[i] * mass[i]);
      part.largest = std::max(part.largest, square);
      part.sum += square;
      part.dv += mass[i] * dv[i].squaredNorm();
    }
    parts[first / chunk_size] = part;
  });
  Part all;
  for (const Part& part : parts) {
    all.sum += part.sum;
    all.largest = std::max(all.largest, part.largest);
    all.dv += part.dv;
  }
  dv_square_ = all.dv;
  return std::sqrt(std::max(all.sum, all.largest * count / (peak_to_mean * peak_to_mean)));
}

// Returns `right` with its positions zeroed at pinned particles, if pins move. Forces take the
// positions of moving pins from the time: their rows are y' = f(t), and K does not see them.
StateView VelocitySystem::with_free_positions(const StateView& right) {
  if (!dynamics_.pins_move()) return right;
  free_position_.assign(right.position.begin(), right.position.end());
  for (std::size_t i = 0; i < free_position_.size(); ++i) {
    if (dynamics_.scene().pinned[i] != 0) free_position_[i].setZero();
  }
  return {free_position_, right.velocity};
}

// Forms r = M b_v - gamma K b_x. K b_x comes from the block matrix, without the damping that is
// joined to it, and from the contact pairs' own stiffness.
void VelocitySystem::form_right_side(const StateView& right) {
  const Scene& scene = dynamics_.scene();
  const double gamma = matrix_.gamma();
  dynamics_.stiffness().multiply(right.position, product_, dynamics_.threads());
  parallel_chunks(dynamics_.particle_count(), dynamics_.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i)
      residual_[i] = scene.mass[i] * right.velocity[i] - gamma * product_[i];
  });
  const std::span<const Vec3> damping = dynamics_.damping_product();
  for (std::size_t i = 0; i < damping.size(); ++i) residual_[i] -= damping[i];
  if (dynamics_.contact() != nullptr)
    dynamics_.contact()->subtract_stiffness(gamma, right.position, residual_);
  for (std::size_t i = 0; i < residual_.size(); ++i) {
    if (scene.pinned[i] != 0) residual_[i].setZero();
  }
  right_side_ = residual_;
}

// Returns the iterations with these coarse matrices in excess of those that the first solve with
// them took for as many digits.
double VelocitySystem::excess(const Outcome& outcome) const {
  if (iterations_a_digit_ == 0) return 0;
  const double digits = std::log10(start_residual_ / outcome.residual);
  return outcome.iterations - start_iterations_ - iterations_a_digit_ * std::max(digits, 0.0);
}

void VelocitySystem::note_iterations(const Outcome& outcome) {
  const int iterations = outcome.iterations - start_iterations_;
  if (!outcome.multigrid || iterations == 0) return;
  if (iterations_a_digit_ == 0) {
    const double digits = std::log10(start_residual_ / outcome.residual);
    iterations_a_digit_ = iterations / std::max(digits, 0.5);
  } else {
    excess_iterations_ += std::max(0.0, excess(outcome));
  }
}

// Forms new coarse matrices if the present ones have worn out within the solve, which then goes on
// with the new ones. Returns whether it did.
bool VelocitySystem::renew(Outcome& outcome) {
  if (preconditioner_ == &block_jacobi_ ||
      !(excess_iterations_ + excess(outcome) > set_up_iterations))
    return false;
  start_iterations_ = outcome.iterations;
  start_residual_ = outcome.residual;
  renewed_until_ = dynamics_.statistics().counters.matrix_assemblies + assemblies_to_renew;
  if (!set_up_multigrid(outcome)) use_block_jacobi();
  return true;
}

bool VelocitySystem::factorise(double gamma, std::span<const double> b,
                               std::span<double> correction, Outcome& outcome) {
  if (gamma < factorised_from_) return false;
  if (factorisations_left_ == 0) {
    factorised_from_ = std::numeric_limits<double>::infinity();
    return false;
  }
  --factorisations_left_;
  if (direct_ == nullptr) direct_ = std::make_unique<DirectSolver>(dynamics_);
  ++outcome.iterations;
  outcome.residual = 0;
  outcome.converged = direct_->solve(gamma, b, correction);
  outcome.indefinite = !outcome.converged;
  return true;
}

// Finds the next direction and its product with A, in single precision where the preconditioner
// offers that. Returns false for a direction of negative curvature.
bool VelocitySystem::turn(bool starts_anew, double& rho, double& curvature) {
  const int count = dynamics_.particle_count(), threads = dynamics_.threads();
  double next = precondition();
  if (!(next > 0) && preconditioner_ != &block_jacobi_) {
    // Rounding causes this in a matrix that is all but singular.
    is_set_up_ = false;
    use_block_jacobi();
    starts_anew = true;
    next = precondition();
  }
  const double beta = starts_anew ? 0 : next / rho;
  const std::span<const Vec3> remainder =
      is_exact_ ? std::span<const Vec3>() : preconditioner_->remainder();
  rho = next;
  has_single_products_ |= !remainder.empty();
  curvature = parallel_sum(count, threads, [&](int first, int last) {
    double sum = 0;
    for (int i = first; i < last; ++i) {
      direction_[i] = preconditioned_[i] + beta * direction_[i];
      if (remainder.empty()) continue;
      product_[i] = residual_[i] - remainder[i] + beta * product_[i];
      sum += direction_[i].dot(product_[i]);
    }
    return sum;
  });
  if (remainder.empty()) {
    matrix_.multiply(direction_, product_);
    curvature = dot(direction_, product_, threads);
  }
  return curvature > 0;
}

// The square of the error falls by each iteration's gain (Hestenes and Stiefel 1952, theorem 6:1).
// From dv = 0, the sum of all gains is the square of dv. The remaining error is extrapolated from
// two sums of gains: over the last third of the iterations and over the third before. The first
// four iterations are left out. Single gains swing where iterations are many.
bool VelocitySystem::is_reached(const Goal& goal, double residual) const {
  if (!(residual <= goal.residual)) return false;
  if (goal.error >= 1 || residual <= rounding * start_residual_) return true;
  const auto end = gains_.end();
  const auto window = std::max<std::ptrdiff_t>(1, (end - gains_.begin() - 4) / 3);
  if (end - gains_.begin() < 2 * window) return false;
  const double last = std::accumulate(end - window, end, 0.0);
  const double before = std::accumulate(end - 2 * window, end - window, 0.0);
  const double all =
      goal.scale == Goal::Scale::mass ? dv_square_ : std::accumulate(gains_.begin(), end, 0.0);
  const double error =
      preconditioner_ == &block_jacobi_ ? goal.error / block_jacobi_doubt : goal.error;
  return last < before && last * last / (before - last) <= error * error * all;
}

// residual_ = right_side_ - A dv.
void VelocitySystem::form_residual(std::span<const Vec3> dv) {
  matrix_.multiply(dv, residual_);
  parallel_chunks(dynamics_.particle_count(), dynamics_.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) residual_[i] = right_side_[i] - residual_[i];
  });
}

// Runs conjugate gradients from dv = 0. Without contact, which single precision leaves out,
// products are in single precision first. These end when they have converged or meet negative
// curvature, which a stiff body may seem to have in single precision. The residual of A itself is
// then formed. Where it is larger than allowed, or than it seemed, iterations go on from it with
// products in double.
void VelocitySystem::iterate(std::span<const Vec3> weight, const Goal& goal, std::span<Vec3> dv,
                             Outcome& outcome) {
  double rho = 1, curvature = 0;
  bool starts_anew = true;
  is_exact_ = matrix_.has_contact();
  has_single_products_ = false;
  gains_.clear();
  outcome.converged = is_reached(goal, outcome.residual);
  while (!outcome.converged && outcome.iterations < largest_iteration_count) {
    starts_anew = renew(outcome) || starts_anew;
    const bool is_definite = turn(starts_anew, rho, curvature);
    if (!is_definite && !has_single_products_) {
      outcome.indefinite = true;
      break;
    }
    if (is_definite) {
      outcome.residual = advance(rho / curvature, weight, dv.data());
      gains_.push_back(rho / curvature * rho);
    }
    ++outcome.iterations;
    outcome.converged = is_reached(goal, outcome.residual);
    starts_anew = has_single_products_ && (!is_definite || outcome.converged);
    if (starts_anew) {
      is_exact_ = true;
      has_single_products_ = false;
      const double seeming = outcome.residual;
      form_residual(dv);
      outcome.residual = advance(0, weight, dv.data());
      outcome.converged = outcome.converged && outcome.residual <= goal.residual &&
                          (goal.error >= 1 || outcome.residual <= 2 * seeming);
    }
  }
}

VelocitySystem::Outcome VelocitySystem::solve(double gamma, std::span<const double> b,
                                              std::span<const double> weight, const Goal& goal,
                                              std::span<double> correction) {
  Outcome outcome;
  if (factorise(gamma, b, correction, outcome)) return outcome;
  if (gamma != matrix_.gamma()) set_up(gamma);
  const StateView right = StateView::of(b);
  const std::span<const Vec3> velocity_weight = StateView::of(weight).velocity;
  const std::vector<char>& pinned = dynamics_.scene().pinned;
  const int count = dynamics_.particle_count();
  auto* dx = reinterpret_cast<Vec3*>(correction.data());
  const std::span<Vec3> dv(dx + count, count);
  prepare(outcome);
  form_right_side(with_free_positions(right));
  // Results of an earlier solve, which may not even be finite, must not enter this one.
  for (const std::span<Vec3> start : {dv, std::span(direction_), std::span(product_)})
    std::fill(start.begin(), start.end(), Vec3::Zero());
  outcome.residual = advance(0, velocity_weight, dv.data());
  start_iterations_ = 0;
  start_residual_ = outcome.residual;
  iterate(velocity_weight, goal, dv, outcome);
  outcome.multigrid = preconditioner_ != &block_jacobi_;
  note_iterations(outcome);
  if (outcome.iterations <= worth_a_factorisation(count)) {
    if (gamma >= hard_gamma_) factorisation_patience_ = 0;
  } else if (dynamics_.scene().source.time.preconditioner == PreconditionerChoice::automatic) {
    factorised_from_ = hard_gamma_ = gamma;
    factorisation_patience_ =
        std::clamp(2 * factorisation_patience_, first_factorisations, most_factorisations);
    factorisations_left_ = factorisation_patience_;
    if (!outcome.converged && !outcome.indefinite) {
      factorise(gamma, b, correction, outcome);
      return outcome;
    }
  }
  for (int i = 0; i < count; ++i) {
    if (pinned[i] != 0 && dynamics_.pins_move()) {
      dx[i] = right.position[i];
      dv[i] = right.velocity[i];
    } else if (pinned[i] != 0) {
      dx[i].setZero();
    } else {
      dx[i] = right.position[i] + gamma * dv[i];
    }
  }
  return outcome;
}

}  // namespace weft::sim
