#include "sim/solver/tangent_factors.h"

#include <algorithm>

namespace weft::sim {

namespace {

// Largest residual of a solution, as a fraction of the right-hand side. For a K that is singular up
// to rounding, the residual is about as large as the right-hand side.
constexpr double largest_residual = 1e-2;

}  // namespace

bool TangentFactors::factorise() {
  ++count_;
  stiffness_ = unknowns_.stiffness(dynamics_, 1);
  return factors_.factorise(stiffness_);
}

int TangentFactors::weakest_particle() const {
  return factors_.weakest() < 0 ? -1 : unknowns_.particle(factors_.weakest());
}

bool TangentFactors::solve(std::span<const Vec3> force, std::span<Vec3> displacement) const {
  if (unknowns_.count() == 0) {
    std::ranges::fill(displacement, Vec3(Vec3::Zero()));
    return true;
  }
  const Eigen::VectorXd right = unknowns_.gather(force);
  const Eigen::VectorXd result = factors_.solve(right);
  if (!result.allFinite()) return false;
  const Eigen::VectorXd product = stiffness_.selfadjointView<Eigen::Lower>() * result;
  if ((product - right).norm() > largest_residual * right.norm()) return false;
  unknowns_.scatter(result, displacement);
  return true;
}

}  // namespace weft::sim
