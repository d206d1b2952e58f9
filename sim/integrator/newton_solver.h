// The reduced velocity system as a SUNDIALS linear solver.
#pragma once

#include <sundials/sundials_linearsolver.h>

#include <functional>
#include <optional>
#include <span>

#include "sim/solver/velocity_system.h"

namespace weft::sim {

// Largest part of a gap by which the last Newton iteration may change it. The iteration ends when
// its corrections are small beside the tolerances. Deep in a barrier they are small, too: each
// lengthens the gap by less than half. Accepted there, a step would store more energy in the
// barrier than there was, though its forces do not balance (docs/decisions/0093).
inline constexpr double most_gap_change = 0.1;
// Changes of gaps count this many times where a pair has closed by more than its gap within the
// step, as in a long step of free fall that ends in a barrier. Its forces are those of an impact,
// and with the damping of contact, corrections are an even smaller part of the gap.
inline constexpr double closing_factor = 5;

// Tolerance of the linear solve as a fraction of the Newton tolerance, for SUNDIALS' integrators
// (docs/decisions/0005).
inline constexpr double linear_tolerance_factor = 0.3;

// Callbacks of the linear solver into the Newton iteration that uses it.
struct NewtonHooks {
  std::function<double()> gamma = {};  // returns gamma (s) of the system to be solved
  // Goal of the linear solves. If empty, the goal is the residual that SUNDIALS passes as
  // tolerance.
  std::optional<VelocitySystem::Goal> goal = {};
  // Replaces the matrices by positive semi-definite ones, when conjugate gradients meet a direction
  // of negative curvature. If the hook is empty or returns false, the solve fails.
  std::function<bool()> make_definite = {};
  // Shortens a correction if necessary. If empty, corrections are not changed.
  std::function<void(std::span<double> correction)> limit = {};
};

// Returns an iterative SUNLinearSolver for (I - gamma J), without a SUNMatrix. It uses the left
// scaling vector that SUNDIALS sets and, if `hooks` has no goal, the tolerance of SUNDIALS. Each
// setup calls the preconditioner setup function that the user gave to SUNDIALS. That function must
// assemble the dynamics' matrices if they are out of date. Free the solver with SUNLinSolFree.
SUNLinearSolver make_newton_solver(Dynamics& dynamics, NewtonHooks hooks, SUNContext context);
// Returns the system that a solver made by make_newton_solver() solves.
VelocitySystem& velocity_system_of(SUNLinearSolver solver);

}  // namespace weft::sim
