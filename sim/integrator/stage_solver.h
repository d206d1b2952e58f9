// Solves one implicit stage, y - gamma f(t, y) = a. SUNDIALS KINSOL iterates until convergence,
// unless the number of iterations is given. A given number of iterations needs neither KINSOL nor
// its vectors.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Newton's method for the stage. A VelocitySystem solves the linear systems. Full corrections start
// from `a` or, without contact, from a + gamma times the slope of the last stage. If they do not
// converge, corrections with a line search on the residual start again from `a`.
//
// Residuals and corrections are weighted by the tolerances of the case: positions by 1 /
// position_tolerance, velocities by 1 / (velocity_tolerance + relative_tolerance |v|). The
// iteration ends when no weighted component of the last correction, or of the residual after it,
// exceeds 0.3. After the first direction of negative curvature, the rest of the stage uses positive
// semi-definite matrices.
//
// With contact, a correction is halved, up to eight times, until the straight path from the last
// accepted positions to its end provably keeps surfaces apart.
class StageSolver {
 public:
  // `newton_count` is the number of iterations. 0 means until convergence, with at most 12 full
  // corrections and 20 with a line search. A given number of iterations starts at `a` and uses
  // semi-definite matrices, without line search, convergence test or halving. With contact, an
  // iteration is solved again, up to twelve times in all, while surfaces would meet
  // (Contact::add_stops()), and once more for friction (Contact::correct_friction()). A step that
  // stretches edges by 0.03 or gains energy counts as not converged, unless it is at most 1/16 of
  // time.step. With prescribed motion too, up to two more iterations follow until the residual
  // velocities are small.
  StageSolver(const Scene& scene, Dynamics& dynamics, int newton_count);
  ~StageSolver();
  StageSolver(const StageSolver&) = delete;
  StageSolver& operator=(const StageSolver&) = delete;

  // `blocked`: surfaces would touch, or the forces cannot be evaluated.
  enum class Outcome { solved, not_converged, blocked };
  // Solves the stage with `gamma` (s) at time `t` (s). `a` is the last accepted state (6 *
  // particles), at the time given to Dynamics::begin_step(); `start` holds the positions (m) of all
  // particles at that time. On success `y` is the solution.
  Outcome solve(double t, double gamma, std::span<const double> a, const std::vector<Vec3>& start,
                std::span<double> y);
  // Returns the last fault met in the last solve(), or nothing. A fault does not block solve() if a
  // shortened correction avoids it.
  const std::optional<ContactFault>& fault() const;
  // Returns the particle with the largest weighted residual velocity in the last solve().
  int worst_particle() const;
  // Sets a function that linear solves call every few iterations. If it returns true, the solve
  // ends, and so does solve(), without having converged. The function must go on returning true.
  void set_stop(std::function<bool()> stop);
  // Discards the slope of the last stage.
  void forget();
  // Writes or reads all data that determine the bits of later solutions.
  void transfer(StateArchive& archive);
  // Adds the numbers of Newton iterations, linear iterations and linear setups since construction.
  void add_counts(IntegratorCounts& counts) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
