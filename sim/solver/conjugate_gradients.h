// Preconditioned conjugate gradients for the Newton system of the velocities.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sim/solver/free_translations.h"
#include "sim/solver/preconditioner_selection.h"
#include "sim/solver/velocity_matrix.h"

namespace weft::sim {

// Solves A dv = b by preconditioned conjugate gradients.
//
// Without contact, the first products with A come from the preconditioner, in single precision, if
// it provides them. After such products, the residual is formed anew in double at convergence, or
// at a negative curvature that rounding may have caused. At convergence, the solve ends if the new
// residual meets the goal and, with an error goal, is at most twice the recursively updated one.
// Otherwise it continues with products in double.
class ConjugateGradients {
 public:
  struct Outcome {
    bool converged = false;
    bool indefinite = false;  // A has a direction of negative curvature
    bool stopped = false;     // the function of set_stop() returned true
    int iterations = 0;
    double residual = 0;     // as in Goal::residual, with Scene::mass instead of M
    bool multigrid = false;  // multigrid was the preconditioner at the end
    int multigrid_set_ups = 0;
  };
  // The conditions that a solution must meet.
  struct Goal {
    // Upper bound of the weighted 2-norm of M^-1 r, with the residual r = b - A dv. No particle may
    // exceed ten times the root mean square that this bound implies.
    double residual = std::numeric_limits<double>::infinity();
    // Upper bound of the relative error of dv. With 1, only the residual is tested. For an error e
    // of dv, the relative error is sqrt(e . A e) / sqrt(dv . M dv) or, with Scale::matrix, sqrt(e .
    // A e) / sqrt(dv . A dv). The solver estimates it from the iterations, and the true value may
    // be larger.
    double error = 1;
    enum class Scale : std::uint8_t { mass, matrix } scale = Scale::mass;
    // True if dv begins as a guess, false if it begins as zero.
    bool from_guess = false;
    // True if the solution ends with a translation of each free body that takes the momentum which
    // the iterations left in the residual (FreeTranslations).
    bool keeps_momentum = false;
  };

  // All arguments must outlive the object.
  ConjugateGradients(const VelocityMatrix& matrix, MassOperator& mass,
                     PreconditionerSelection& preconditioner);

  // Sets a function that solve() calls every few iterations. If it returns true, the solve ends
  // without having converged. An empty function never stops a solve.
  void set_stop(std::function<bool()> stop) { stop_ = std::move(stop); }

  // Solves A dv = `right_side`, starting from dv = 0 or, with Goal::from_guess, from the given dv.
  // Both vectors are zero for pinned particles.
  // All spans have one entry per particle. Precondition: PreconditionerSelection::prepare() has
  // been called for this A.
  Outcome solve(std::span<const Vec3> right_side, std::span<const Vec3> weight, const Goal& goal,
                std::span<Vec3> dv);

 private:
  // The arguments of solve().
  struct Solve {
    std::span<const Vec3> right_side, weight;
    const Goal& goal;
    std::span<Vec3> dv;
  };

  // Sums over particles: of squared weighted residuals divided by the mass, the largest of these,
  // and dv . M dv with Scene::mass.
  struct Measure {
    double sum = 0, largest = 0, dv = 0;
  };

  void iterate(const Solve& solve, Outcome& outcome);
  void keep_momentum(const Solve& solve);
  bool should_stop(int iterations) const;
  bool is_reached(const Solve& solve, double residual);
  bool is_small(const Solve& solve, double residual);
  double coupled_residual(const Solve& solve);
  double inertia(std::span<const Vec3> dv) const;
  bool find_direction(bool begins_anew);
  double precondition();
  double advance(double alpha, const Solve& solve);
  void measure(const Solve& solve, int begin, int end, Measure& part) const;
  void form_residual(const Solve& solve);

  const VelocityMatrix& matrix_;
  MassOperator& mass_;
  PreconditionerSelection& preconditioner_;
  std::function<bool()> stop_;
  std::optional<FreeTranslations> translations_;  // made at first use
  std::vector<double> inverse_mass_;  // 1/kg, by particle: multiplications take less than divisions
  std::vector<Vec3> residual_, preconditioned_;
  std::vector<Vec3> direction_, product_;  // search direction p, and A p
  double rho_ = 1, curvature_ = 0;         // r . P r, and p . A p
  bool is_exact_ = false;                  // true if products with A must be formed in double
  bool has_single_products_ = false;  // true if the residual contains single-precision products
  double start_residual_ = 0;  // residual at the start or at the last rebuild of coarse matrices
  std::vector<double> gains_;  // decrease of the squared error in each iteration of this solve
  double dv_square_ = 0;       // dv . M dv, with Scene::mass in place of M
};

}  // namespace weft::sim
