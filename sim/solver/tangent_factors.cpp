#include "sim/solver/tangent_factors.h"

namespace weft::sim {

bool TangentFactors::factorise() {
  ++count_;
  return factors_.factorise(unknowns_.stiffness(dynamics_, 1));
}

int TangentFactors::weakest_particle() const {
  return factors_.weakest() < 0 ? -1 : unknowns_.particle(factors_.weakest());
}

bool TangentFactors::solve(std::span<const Vec3> force, std::span<Vec3> displacement) const {
  if (unknowns_.count() == 0) {
    std::ranges::fill(displacement, Vec3(Vec3::Zero()));
    return true;
  }
  const Eigen::VectorXd result = factors_.solve(unknowns_.gather(force));
  unknowns_.scatter(result, displacement);
  return result.allFinite();
}

}  // namespace weft::sim
