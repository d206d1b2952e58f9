// The reduced velocity system as a SUNDIALS linear solver.
#pragma once

#include <sundials/sundials_linearsolver.h>

#include <functional>
#include <optional>
#include <span>

#include "sim/solver/velocity_system.h"

namespace weft::sim {

// Tolerance of the linear solve as a fraction of the Newton tolerance, for SUNDIALS' integrators
// (docs/decisions/0005).
inline constexpr double linear_tolerance_factor = 0.3;

// Callbacks of the linear solver into the Newton iteration that uses it.
struct NewtonHooks {
  std::function<double()> gamma = {};  // of the system in hand
  // Goal of the linear solves; empty: the residual that SUNDIALS asks for.
  std::optional<VelocitySystem::Goal> goal = {};
  // Called when conjugate gradients meet a direction of negative curvature: assembles positive
  // semi-definite matrices instead. If it is empty or returns false, the solve fails.
  std::function<bool()> make_definite = {};
  // May shorten the correction just found. Empty: left as it is.
  std::function<void(std::span<double> correction)> limit = {};
};

// An iterative, matrix-free SUNLinearSolver for (I - gamma J): honours the tolerance and the
// scaling vectors it is given. The preconditioner setup function of the SUNDIALS solver that uses
// it is called at each setup, and must assemble the dynamics' matrices where they are out of date.
// Free with SUNLinSolFree.
SUNLinearSolver make_newton_solver(Dynamics& dynamics, NewtonHooks hooks, SUNContext context);
// Returns the system that such a solver solves.
VelocitySystem& velocity_system_of(SUNLinearSolver solver);

}  // namespace weft::sim
