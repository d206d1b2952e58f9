#include "sim/integrator/velocity_system.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/parallel.h"

namespace weft::sim {

namespace {

// A residual that has not fallen far enough by then means a matrix that conjugate gradients cannot
// handle: the caller is told, and cuts the step.
constexpr int largest_iteration_count = 2000;

// A mean over thousands of particles lets a few of them be solved hardly at all. Where these are
// held by stiff friction they then swing to and fro from step to step, and the error control
// answers with steps of microseconds without end.
constexpr double peak_to_mean = 10;

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
      matrix_(dynamics.stiffness()),
      inverse_diagonal_(dynamics.particle_count()),
      residual_(dynamics.particle_count()),
      direction_(dynamics.particle_count()),
      product_(dynamics.particle_count()),
      preconditioned_(dynamics.particle_count()) {}

void VelocitySystem::set_up(double gamma) {
  gamma_ = gamma;
  const std::span<const double> stiffness = dynamics_.stiffness().values();
  const std::span<const double> damping = dynamics_.damping().values();
  const std::span<double> values = matrix_.values();
  const bool damped = dynamics_.has_damping();
  parallel_chunks(static_cast<int>(values.size()), dynamics_.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) values[i] = gamma * gamma * stiffness[i];
    if (!damped) return;
    for (int i = first; i < last; ++i) values[i] += gamma * damping[i];
  });
  for (int i = 0; i < dynamics_.particle_count(); ++i) {
    matrix_.block(matrix_.pattern().diagonal_slot(i)).diagonal().array() +=
        dynamics_.scene().mass[i];
  }
}

void VelocitySystem::multiply(std::span<const Vec3> in, std::span<Vec3> out) const {
  matrix_.multiply(in, out, dynamics_.threads());
  if (dynamics_.contact() != nullptr) dynamics_.contact()->add_product(gamma_, in, out);
  const std::vector<char>& pinned = dynamics_.scene().pinned;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (pinned[i] != 0) out[i].setZero();
  }
}

void VelocitySystem::invert_diagonal() {
  for (std::size_t i = 0; i < inverse_diagonal_.size(); ++i) {
    inverse_diagonal_[i] = matrix_.block(matrix_.pattern().diagonal_slot(static_cast<int>(i)));
  }
  if (dynamics_.contact() != nullptr) dynamics_.contact()->add_diagonal(gamma_, inverse_diagonal_);
  for (std::size_t i = 0; i < inverse_diagonal_.size(); ++i) {
    // Compressed cloth can make a block indefinite; the mass alone is then a safe preconditioner.
    const Mat3 block = inverse_diagonal_[i];
    const double mass = dynamics_.scene().mass[i];
    const bool definite =
        block(0, 0) > 0 && block.topLeftCorner<2, 2>().determinant() > 0 && block.determinant() > 0;
    inverse_diagonal_[i] = definite ? Mat3(block.inverse()) : Mat3(Mat3::Identity() / mass);
  }
}

double VelocitySystem::precondition() {
  parallel_chunks(static_cast<int>(residual_.size()), dynamics_.threads(),
                  [&](int first, int last) {
                    for (int i = first; i < last; ++i)
                      preconditioned_[i] = inverse_diagonal_[i] * residual_[i];
                  });
  return dot(residual_, preconditioned_, dynamics_.threads());
}

// The 2-norm, or, where that is larger, so many times the largest share of one particle that no
// particle's residual exceeds `peak_to_mean` times the mean.
double VelocitySystem::weighted_residual(std::span<const Vec3> weight) const {
  const std::vector<double>& mass = dynamics_.scene().mass;
  const int count = static_cast<int>(residual_.size());
  double largest = 0;
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const double square = residual_[i].cwiseProduct(weight[i]).squaredNorm() / (mass[i] * mass[i]);
    largest = std::max(largest, square);
    sum += square;
  }
  return std::sqrt(std::max(sum, largest * count / (peak_to_mean * peak_to_mean)));
}

VelocitySystem::Outcome VelocitySystem::solve(double gamma, std::span<const double> b,
                                              std::span<const double> weight, double tolerance,
                                              std::span<double> correction, double relative) {
  if (gamma != gamma_) set_up(gamma);
  const StateView right = StateView::of(b);
  const std::span<const Vec3> velocity_weight = StateView::of(weight).velocity;
  const std::vector<double>& mass = dynamics_.scene().mass;
  const std::vector<char>& pinned = dynamics_.scene().pinned;
  const int count = dynamics_.particle_count(), threads = dynamics_.threads();
  auto* dx = reinterpret_cast<Vec3*>(correction.data());
  Vec3* dv = dx + count;
  invert_diagonal();

  // r = M b_v - gamma K b_x; since gamma^2 K = A - M - gamma D is what is at hand with contact in
  // it, K b_x comes from the block matrix and the contact pairs' own stiffness.
  dynamics_.stiffness().multiply(right.position, product_, threads);
  for (int i = 0; i < count; ++i) residual_[i] = -gamma * product_[i];
  if (dynamics_.contact() != nullptr)
    dynamics_.contact()->subtract_stiffness(gamma, right.position, residual_);
  for (int i = 0; i < count; ++i) {
    residual_[i] += mass[i] * right.velocity[i];
    if (pinned[i] != 0) residual_[i].setZero();
    dv[i].setZero();
  }

  Outcome outcome;
  double rho = precondition();
  direction_ = preconditioned_;
  outcome.residual = weighted_residual(velocity_weight);
  tolerance = std::min(tolerance, relative * outcome.residual);
  while (outcome.residual > tolerance && outcome.iterations < largest_iteration_count) {
    multiply(direction_, product_);
    const double curvature = dot(direction_, product_, threads);
    if (!(curvature > 0)) {
      outcome.indefinite = true;
      break;
    }
    const double alpha = rho / curvature;
    parallel_chunks(count, threads, [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        dv[i] += alpha * direction_[i];
        residual_[i] -= alpha * product_[i];
      }
    });
    const double next = precondition();
    const double beta = next / rho;
    rho = next;
    parallel_chunks(count, threads, [&](int first, int last) {
      for (int i = first; i < last; ++i) direction_[i] = preconditioned_[i] + beta * direction_[i];
    });
    outcome.residual = weighted_residual(velocity_weight);
    ++outcome.iterations;
  }
  outcome.converged = outcome.residual <= tolerance;
  for (int i = 0; i < count; ++i) {
    if (pinned[i] != 0) {
      dx[i].setZero();
    } else {
      dx[i] = right.position[i] + gamma * dv[i];
    }
  }
  return outcome;
}

}  // namespace weft::sim
