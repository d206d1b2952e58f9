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
  std::function<double()> gamma = {};  // s, of the system to be solved
  // Goal of the linear solves. Empty: the residual that SUNDIALS requests.
  std::optional<VelocitySystem::Goal> goal = {};
  // Called when conjugate gradients meet a direction of negative curvature; replaces the matrices
  // by positive semi-definite ones. If it is empty or returns false, the solve fails.
  std::function<bool()> make_definite = {};
  // May shorten the correction just found. Empty: the correction is kept.
  std::function<void(std::span<double> correction)> limit = {};
};

// Returns an iterative, matrix-free SUNLinearSolver for (I - gamma J) that honours the given
// tolerance and scaling vectors. Each setup calls the preconditioner setup function of the SUNDIALS
// solver that uses it. That function must assemble the dynamics' matrices if they are out of date.
// Free with SUNLinSolFree.
SUNLinearSolver make_newton_solver(Dynamics& dynamics, NewtonHooks hooks, SUNContext context);
// Returns the system that a solver made by make_newton_solver() solves.
VelocitySystem& velocity_system_of(SUNLinearSolver solver);

}  // namespace weft::sim
