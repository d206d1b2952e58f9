#include "sim/integrator/newton_solver.h"

#include "sim/integrator/sundials_access.h"
#include "sim/solver/velocity_system.h"

namespace weft::sim {

namespace {

struct Content {
  Content(Dynamics& dynamics_, NewtonHooks hooks_)
      : dynamics(dynamics_), system(dynamics_), hooks(std::move(hooks_)) {}
  Dynamics& dynamics;
  VelocitySystem system;
  NewtonHooks hooks;
  // The preconditioner's setup function: SUNDIALS passes the present state only to it.
  SUNPSetupFn setup = nullptr;
  void* setup_data = nullptr;
  N_Vector weight = nullptr;
  int iterations = 0;
  double residual = 0;
};

Content& content_of(SUNLinearSolver solver) { return *static_cast<Content*>(solver->content); }

int set_up(SUNLinearSolver solver, SUNMatrix) {
  Content& content = content_of(solver);
  if (content.setup != nullptr && content.setup(content.setup_data) != 0)
    return SUNLS_PSET_FAIL_REC;
  const double gamma = content.hooks.gamma();
  PhaseTimer timer(content.dynamics.statistics().phases.linear_solve);
  content.system.set_up(gamma);
  return SUNLS_SUCCESS;
}

int solve(SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, realtype tolerance) {
  Content& content = content_of(solver);
  const double gamma = content.hooks.gamma();
  const auto attempt = [&] {
    PhaseTimer timer(content.dynamics.statistics().phases.linear_solve);
    return content.system.solve(
        gamma, values(b), values(content.weight),
        content.hooks.goal.value_or(VelocitySystem::Goal{.residual = tolerance}), values(x));
  };
  VelocitySystem::Outcome outcome = attempt();
  content.iterations = outcome.iterations;
  if (outcome.indefinite && content.hooks.make_definite && content.hooks.make_definite()) {
    content.system.set_up(gamma);
    outcome = attempt();
    content.iterations += outcome.iterations;
  }
  content.residual = outcome.residual;
  if (!outcome.converged) return outcome.indefinite ? SUNLS_PSOLVE_FAIL_REC : SUNLS_CONV_FAIL;
  if (content.hooks.limit) content.hooks.limit(values(x));
  return SUNLS_SUCCESS;
}

}  // namespace

VelocitySystem& velocity_system_of(SUNLinearSolver solver) { return content_of(solver).system; }

SUNLinearSolver make_newton_solver(Dynamics& dynamics, NewtonHooks hooks, SUNContext context) {
  SUNLinearSolver solver = SUNLinSolNewEmpty(context);
  solver->content = new Content(dynamics, std::move(hooks));
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
