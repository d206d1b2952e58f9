#include "sim/integrator/newton_solver.h"

#include <cvode/cvode.h>
#include <cvode/cvode_ls.h>
#include <nvector/nvector_serial.h>

#include "sim/integrator/velocity_system.h"

namespace weft::sim {

namespace {

struct Content {
  Content(Dynamics& dynamics_, void* cvode_)
      : dynamics(dynamics_), system(dynamics_), cvode(cvode_) {}
  Dynamics& dynamics;
  VelocitySystem system;
  void* cvode;
  // CVODE tells the state at a setup to the preconditioner's setup function alone.
  SUNPSetupFn setup = nullptr;
  void* setup_data = nullptr;
  N_Vector weight = nullptr;
  int iterations = 0;
  double residual = 0;
};

Content& content_of(SUNLinearSolver solver) { return *static_cast<Content*>(solver->content); }

std::span<double> values(N_Vector v) {
  return {NV_DATA_S(v), static_cast<std::size_t>(NV_LENGTH_S(v))};
}

int set_up(SUNLinearSolver solver, SUNMatrix) {
  Content& content = content_of(solver);
  if (content.setup != nullptr && content.setup(content.setup_data) != 0)
    return SUNLS_PSET_FAIL_REC;
  double gamma = 0;
  CVodeGetCurrentGamma(content.cvode, &gamma);
  PhaseTimer timer(content.dynamics.statistics().phases.linear_solve);
  content.system.set_up(gamma);
  return SUNLS_SUCCESS;
}

int solve(SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, realtype tolerance) {
  Content& content = content_of(solver);
  double gamma = 0;
  CVodeGetCurrentGamma(content.cvode, &gamma);
  PhaseTimer timer(content.dynamics.statistics().phases.linear_solve);
  const VelocitySystem::Outcome outcome =
      content.system.solve(gamma, values(b), values(content.weight), tolerance, values(x));
  content.iterations = outcome.iterations;
  content.residual = outcome.residual;
  if (outcome.converged) return SUNLS_SUCCESS;
  return outcome.indefinite ? SUNLS_PSOLVE_FAIL_REC : SUNLS_CONV_FAIL;
}

}  // namespace

SUNLinearSolver make_newton_solver(Dynamics& dynamics, void* cvode, SUNContext context) {
  SUNLinearSolver solver = SUNLinSolNewEmpty(context);
  solver->content = new Content(dynamics, cvode);
  solver->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_ITERATIVE; };
  solver->ops->getid = [](SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; };
  solver->ops->setatimes = [](SUNLinearSolver, void*, SUNATimesFn) { return 0; };
  solver->ops->setpreconditioner = [](SUNLinearSolver s, void* data, SUNPSetupFn setup,
                                      SUNPSolveFn) {
    content_of(s).setup = setup;
    content_of(s).setup_data = data;
    return 0;
  };
  solver->ops->setscalingvectors = [](SUNLinearSolver s, N_Vector left, N_Vector) {
    content_of(s).weight = left;
    return 0;
  };
  solver->ops->initialize = [](SUNLinearSolver) { return 0; };
  solver->ops->setup = set_up;
  solver->ops->solve = solve;
  solver->ops->numiters = [](SUNLinearSolver s) { return content_of(s).iterations; };
  solver->ops->resnorm = [](SUNLinearSolver s) { return content_of(s).residual; };
  solver->ops->free = [](SUNLinearSolver s) {
    delete static_cast<Content*>(s->content);
    s->content = nullptr;
    SUNLinSolFreeEmpty(s);
    return 0;
  };
  return solver;
}

}  // namespace weft::sim
