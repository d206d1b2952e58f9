// One implicit stage, y - gamma f(t, y) = a, solved by SUNDIALS KINSOL or, with a given number of
// iterations, which needs none of its vectors, without.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Newton's method with whole corrections from `a` or, without contact, from as far along the slope
// of the last stage as this one is long and, where these do not converge, from `a` with a line
// search on the residual; each correction by newton_solver.h. Residuals and corrections are
// weighted as in the tolerances of the case: positions by 1 / position_tolerance, velocities by 1 /
// (velocity_tolerance + relative_tolerance |v|). Done when no weighted component of the last
// correction, or of the residual that it leaves, is above 0.3. Where negative curvature is met, the
// rest of the stage uses positive semi-definite matrices. With contact, a correction is halved
// until the straight path from the last accepted positions to where it leads is certain to keep
// surfaces apart, and the line search is confined to it.
class StageSolver {
 public:
  // `newton_count`: so many iterations from `a`, with neither line search nor test of convergence
  // nor halving, on semi-definite matrices from the start; beside contact and prescribed motion up
  // to 12 more, until the residual velocities are small. 0: until they converge, 12 whole ones and
  // 20 with a line search at the most.
  StageSolver(const Scene& scene, Dynamics& dynamics, int newton_count);
  ~StageSolver();
  StageSolver(const StageSolver&) = delete;
  StageSolver& operator=(const StageSolver&) = delete;

  enum class Outcome { solved, not_converged, blocked };  // blocked: surfaces stand in the way
  // `a` is the last accepted state (6 * particles), of the time for which the dynamics have been
  // told that a step begins, of whose particles (all of them) `start` are the positions. The
  // solution, where there is one, is left in `y`.
  Outcome solve(double t, double gamma, std::span<const double> a, const std::vector<Vec3>& start,
                std::span<double> y);
  // Of the last solve(): what stood in the way, and where the residual was largest.
  const std::optional<ContactFault>& fault() const;
  int worst_particle() const;
  // Newton and linear iterations and setups so far.
  void add_counts(IntegratorCounts& counts) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
