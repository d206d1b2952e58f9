// The reduced velocity system as a SUNDIALS linear solver.
#pragma once

#include <sundials/sundials_linearsolver.h>

#include "sim/integrator/dynamics.h"

namespace weft::sim {

// An iterative, matrix-free SUNLinearSolver for (I - gamma J): honours the tolerance and the
// scaling vectors it is given. `cvode` is asked for the current gamma; its preconditioner setup
// function is called at each setup, and must assemble the dynamics' matrices where they are out of
// date. Free with SUNLinSolFree.
SUNLinearSolver make_newton_solver(Dynamics& dynamics, void* cvode, SUNContext context);

}  // namespace weft::sim
