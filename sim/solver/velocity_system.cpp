#include "sim/solver/velocity_system.h"

#include <algorithm>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

// Largest velocity b_x / gamma that is left out of a solve, in units of the tolerance of
// velocities.
constexpr double negligible_velocity = 1e-6;

std::span<Vec3> velocities_of(std::span<double> correction) {
  const std::size_t count = correction.size() / 6;
  return {reinterpret_cast<Vec3*>(correction.data()) + count, count};
}

}  // namespace

VelocitySystem::VelocitySystem(Dynamics& dynamics)
    : dynamics_(dynamics),
      matrix_(dynamics),
      preconditioner_(dynamics, matrix_),
      conjugate_gradients_(matrix_, dynamics.mass(), preconditioner_),
      factorisation_(
          iterations_per_factorisation(dynamics.particle_count()),
          dynamics.scene().source.time.preconditioner == PreconditionerChoice::automatic),
      right_side_(dynamics.particle_count()) {}

void VelocitySystem::set_up(double gamma) { matrix_.form(gamma); }

void VelocitySystem::find_diagonal(std::span<Mat3> diagonal) const {
  const BlockPattern& pattern = *matrix_.pattern();
  for (int i = 0; i < dynamics_.particle_count(); ++i)
    diagonal[i] = matrix_.block(i, pattern.diagonal_slot(i));
  if (dynamics_.contact() != nullptr) dynamics_.contact()->add_diagonal(matrix_.gamma(), diagonal);
}

void VelocitySystem::transfer(StateArchive& archive) {
  factorisation_.transfer(archive);
  preconditioner_.transfer(archive);
}

void VelocitySystem::factorise(double gamma, std::span<const double> b,
                               std::span<const double> weight, std::span<double> correction,
                               Outcome& outcome) {
  ++dynamics_.statistics().counters.sparse_factorisations;
  ++outcome.iterations;
  outcome.residual = 0;
  outcome.converged = solve_directly(gamma, b, weight, correction);
  outcome.indefinite = !outcome.converged;
}

bool VelocitySystem::solve_directly(double gamma, std::span<const double> b,
                                    std::span<const double> weight, std::span<double> correction) {
  if (direct_ == nullptr) direct_ = std::make_unique<DirectSolver>(dynamics_);
  if (gamma != matrix_.gamma()) set_up(gamma);
  const StateView right = StateView::of(b);
  form_right_side(with_free_positions(right), StateView::of(weight).velocity);
  if (!direct_->solve(gamma, right_side_, velocities_of(correction))) return false;
  complete_correction(right, correction);
  return true;
}

// Returns `right` with the positions of pinned particles set to zero if pins move. Forces compute
// the positions of moving pins from the time, so K must not multiply these entries.
StateView VelocitySystem::with_free_positions(const StateView& right) {
  if (!dynamics_.pins_move()) return right;
  free_position_.assign(right.position.begin(), right.position.end());
  for (std::size_t i = 0; i < free_position_.size(); ++i) {
    if (dynamics_.scene().pinned[i] != 0) free_position_[i].setZero();
  }
  return {free_position_, right.velocity};
}

// Returns the velocities, with zeros for pinned particles if M couples pinned particles to free
// ones. Forces compute the accelerations of pins from the time.
std::span<const Vec3> VelocitySystem::with_free_velocities(std::span<const Vec3> velocity) {
  if (dynamics_.mass().is_diagonal()) return velocity;
  free_velocity_.assign(velocity.begin(), velocity.end());
  matrix_.clear_pinned(free_velocity_);
  return free_velocity_;
}

// True if b_x is so small that the solution hardly depends on it. K b_x gamma changes the solution
// by (M + gamma D + gamma^2 K)^-1 gamma K b_x, which is no larger than b_x / gamma. After the first
// correction of a step, b_x is a rounding error (docs/decisions/0101).
bool VelocitySystem::has_negligible_positions(const StateView& right,
                                              std::span<const Vec3> weight) const {
  const double bound = negligible_velocity * matrix_.gamma();
  const auto is_small = [&](int first, int last, char& all) {
    all = 1;
    for (int i = first; i < last; ++i) {
      if (!(right.position[i].cwiseProduct(weight[i]).squaredNorm() <= bound * bound)) all = 0;
    }
  };
  const auto parts =
      parallel_parts<char>(dynamics_.particle_count(), dynamics_.threads(), is_small);
  return std::ranges::find(parts, 0) == parts.end();
}

// Forms M b_v - gamma K b_x, contact included. If the stored stiffness includes D
// (Dynamics::assemble_joined()), subtracting damping_product() removes D again.
void VelocitySystem::form_right_side(const StateView& right, std::span<const Vec3> weight) {
  const MassOperator& mass = dynamics_.mass();
  const double gamma = matrix_.gamma();
  const std::span<const Vec3> velocity = with_free_velocities(right.velocity);
  const std::span<const Vec3> damping = dynamics_.damping_product();
  const bool is_negligible = damping.empty() && has_negligible_positions(right, weight);
  if (!is_negligible)
    dynamics_.stiffness().multiply(right.position, right_side_, dynamics_.threads());
  parallel_chunks(dynamics_.particle_count(), dynamics_.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const Vec3 inertia = mass.row_product(i, velocity.data());
      right_side_[i] = is_negligible ? inertia : Vec3(inertia - gamma * right_side_[i]);
    }
  });
  for (std::size_t i = 0; i < damping.size(); ++i) right_side_[i] -= damping[i];
  if (!is_negligible && dynamics_.contact() != nullptr)
    dynamics_.contact()->subtract_stiffness(gamma, right.position, right_side_);
  matrix_.clear_pinned(right_side_);
}

// Sets dx = b_x + gamma dv for free particles, and the entries of pinned particles.
void VelocitySystem::complete_correction(const StateView& right,
                                         std::span<double> correction) const {
  const std::vector<char>& pinned = dynamics_.scene().pinned;
  const int count = dynamics_.particle_count();
  const double gamma = matrix_.gamma();
  auto* const dx = reinterpret_cast<Vec3*>(correction.data());
  Vec3* const dv = dx + count;
  parallel_chunks(count, dynamics_.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      if (pinned[i] != 0 && dynamics_.pins_move()) {
        dx[i] = right.position[i];
        dv[i] = right.velocity[i];
      } else if (pinned[i] != 0) {
        dx[i].setZero();
      } else {
        dx[i] = right.position[i] + gamma * dv[i];
      }
    }
  });
}

VelocitySystem::Outcome VelocitySystem::solve(double gamma, std::span<const double> b,
                                              std::span<const double> weight, const Goal& goal,
                                              std::span<double> correction) {
  Outcome outcome;
  if (factorisation_.take_hard_system(gamma)) {
    factorise(gamma, b, weight, correction, outcome);
    return outcome;
  }
  if (gamma != matrix_.gamma()) set_up(gamma);
  const StateView right = StateView::of(b);
  const std::span<Vec3> dv = velocities_of(correction);
  preconditioner_.prepare();
  form_right_side(with_free_positions(right), StateView::of(weight).velocity);
  outcome = conjugate_gradients_.solve(right_side_, StateView::of(weight).velocity, goal, dv);
  if (outcome.stopped) return outcome;
  const bool is_hard = factorisation_.record(gamma, outcome.iterations);
  if (is_hard && !outcome.converged && !outcome.indefinite &&
      factorisation_.take_hard_system(gamma)) {
    factorise(gamma, b, weight, correction, outcome);
    return outcome;
  }
  complete_correction(right, correction);
  return outcome;
}

}  // namespace weft::sim
