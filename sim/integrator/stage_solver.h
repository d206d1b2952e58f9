// One implicit stage, y - gamma f(t, y) = a. SUNDIALS KINSOL solves it, except with a given number
// of iterations, which needs none of KINSOL's vectors.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Newton's method; newton_solver.h solves for each correction. Full corrections start from `a` or,
// without contact, from a + gamma times the slope of the last stage. If they do not converge,
// corrections with a line search on the residual start again from `a`.
// Residuals and corrections are weighted by the tolerances of the case: positions by 1 /
// position_tolerance, velocities by 1 / (velocity_tolerance + relative_tolerance |v|). The
// iteration ends when no weighted component of the last correction, or of the residual it leaves,
// exceeds 0.3. Once negative curvature is met, the rest of the stage uses positive semi-definite
// matrices.
// With contact, a correction is halved until the straight path from the last accepted positions to
// its end is certain to keep surfaces apart. The line search stays on that path.
class StageSolver {
 public:
  // `newton_count` > 0: this many iterations from `a`, with semi-definite matrices and without line
  // search, convergence test or halving. With contact and prescribed motion up to 12 more follow,
  // until the residual velocities are small. 0: iterations until they converge, at most 12 full
  // ones and 20 with a line search.
  StageSolver(const Scene& scene, Dynamics& dynamics, int newton_count);
  ~StageSolver();
  StageSolver(const StageSolver&) = delete;
  StageSolver& operator=(const StageSolver&) = delete;

  enum class Outcome { solved, not_converged, blocked };  // blocked: by surfaces
  // Solves the stage at time `t` (s). `a` is the last accepted state (6 * particles), at the time
  // given to Dynamics::begin_step(); `start` holds the positions of all particles then. On success
  // `y` is the solution.
  Outcome solve(double t, double gamma, std::span<const double> a, const std::vector<Vec3>& start,
                std::span<double> y);
  // Return what blocked the last solve(), and the particle with the largest residual.
  const std::optional<ContactFault>& fault() const;
  int worst_particle() const;
  // Discards the slope of the last stage.
  void forget();
  // Writes or reads all that the bits of later solutions depend on.
  void transfer(StateArchive& archive);
  // Adds the numbers of Newton and linear iterations and of setups so far.
  void add_counts(IntegratorCounts& counts) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
