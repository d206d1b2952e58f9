#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_ls.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <limits>

#include "sim/case/case_text.h"
#include "sim/integrator/first_step.h"
#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/newton_solver.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/sundials_access.h"
#include "sim/integrator/vector_operations.h"
#include "sim/motion/spectral_estimate.h"
#include "sim/motion/tolerances.h"
#include "sim/motion/work.h"

namespace weft::sim {

namespace {

// Product of step and fastest rate of the motion at which stability limits the explicit method, as
// measured. `explicit_stages` is the number of force evaluations per step.
constexpr double explicit_limit = 2.7;
constexpr double explicit_stages = 6;

// Without contact, the cost of implicit steps is compared with that of explicit steps after every
// `measured_steps` implicit steps. If stability limits explicit steps, implicit steps are tried
// again after `first_explicit_steps` explicit ones; this number doubles each time.
constexpr std::int64_t measured_steps = 20;
constexpr std::int64_t first_explicit_steps = 500;
// Explicit steps take over if their predicted cost is below this fraction of the implicit cost. The
// margin keeps the two methods from alternating.
constexpr double worthwhile = 0.7;
// Steps are still growing from the short first ones if the last step exceeds this multiple of the
// mean step. Their cost then says nothing about later steps.
constexpr double growing = 1.5;

class ArkodeIntegrator final : public OneStepIntegrator {
 public:
  ArkodeIntegrator(const Scene& scene, Dynamics& dynamics) : OneStepIntegrator(scene, dynamics) {
    SUNContext_Create(nullptr, &context_);
    y_ =
        make_vector(static_cast<sunindextype>(dynamics.state_size()), dynamics.threads(), context_);
    create(true);
    ARKStepSetInitStep(arkode_, first_step(dynamics, 0, state()));
    decision_ = "implicit Runge-Kutta steps";
  }
  ~ArkodeIntegrator() override {
    destroy();
    N_VDestroy(y_);
    SUNContext_Free(&context_);
  }
  ArkodeIntegrator(const ArkodeIntegrator&) = delete;
  ArkodeIntegrator& operator=(const ArkodeIntegrator&) = delete;

  int last_order() const override { return implicit_ ? 2 : 4; }
  IntegratorCounts counts() const override {
    IntegratorCounts counts = OneStepIntegrator::counts();
    counts.error_test_failures += earlier_.error_test_failures + count(ARKStepGetNumErrTestFails);
    if (!implicit_) {
      counts.newton_iterations = earlier_.newton_iterations;
      counts.linear_iterations = earlier_.linear_iterations;
      counts.linear_setups = earlier_.linear_setups;
      counts.convergence_failures += earlier_.convergence_failures;
      return counts;
    }
    counts.newton_iterations = earlier_.newton_iterations + count(ARKStepGetNumNonlinSolvIters);
    counts.linear_iterations = earlier_.linear_iterations + count(ARKStepGetNumLinIters);
    counts.linear_setups = earlier_.linear_setups + count(ARKStepGetNumLinSolvSetups);
    counts.convergence_failures +=
        earlier_.convergence_failures + count(ARKStepGetNumNonlinSolvConvFails);
    return counts;
  }
  std::string decision() const override { return decision_; }
  void transfer(StateArchive& archive) override;

 private:
  long count(int (*get)(void*, long*)) const { return counter_of(arkode_, get); }
  void create(bool implicit);
  void destroy();
  void set_implicit_options();
  Trouble attempt(double& end, std::span<double> y) override;
  bool set_stop_time(double end);
  void pass_event(bool jumps) override {
    if (jumps) arkode_time_ = std::numeric_limits<double>::quiet_NaN();
  }
  void forget() override { arkode_time_ = std::numeric_limits<double>::quiet_NaN(); }
  Trouble trouble_of(int flag, double& end);
  void note_error();
  double work() const;
  IntegratorCounts counts_of_solvers() const;
  void reconsider();
  void use(bool implicit, double rate, double part_of_cost);

  SUNContext context_ = nullptr;
  void* arkode_ = nullptr;
  N_Vector y_ = nullptr;
  SUNNonlinearSolver newton_iteration_ = nullptr;
  NewtonAttempts attempts_;
  SUNLinearSolver newton_solver_ = nullptr;
  bool implicit_ = true;
  double arkode_time_ = 0;  // time that ARKODE has reached (s); if not time(), ARKODE is reset
  // True if the last step ended at ARKODE's stop time. ARKStepGetCurrentStep() then does not return
  // the length of the next step but an earlier one, which may be much shorter.
  bool was_stopped_ = false;
  IntegratorCounts earlier_;  // counts of solvers already destroyed
  std::optional<ContactFault> fault_in_step_;
  std::string decision_;
  // Number of accepted steps at the last comparison of the two methods, and number of explicit
  // steps until the next comparison.
  std::int64_t steps_at_comparison_ = 0, explicit_steps_ = first_explicit_steps;
  double work_at_comparison_ = 0, time_at_comparison_ = 0;
};

void ArkodeIntegrator::create(bool implicit) {
  implicit_ = implicit;
  std::copy(state().begin(), state().end(), values(y_).begin());
  const ARKRhsFn rate = [](realtype t, N_Vector y, N_Vector out, void* self_pointer) {
    auto& self = *static_cast<ArkodeIntegrator*>(self_pointer);
    if (self.implicit_) self.attempts_.note_iterate(t, self.dynamics());
    auto fault = self.dynamics().rate(t, values(y), values(out));
    if (fault) self.fault_in_step_ = fault;
    return fault ? 1 : 0;
  };
  arkode_ =
      ARKStepCreate(implicit ? nullptr : rate, implicit ? rate : nullptr, time(), y_, context_);
  arkode_time_ = time();
  was_stopped_ = false;
  ARKStepSetUserData(arkode_, this);
  ARKStepSetErrHandlerFn(
      arkode_, [](int, const char*, const char*, char*, void*) {}, nullptr);
  ARKStepWFtolerances(arkode_, [](N_Vector y, N_Vector weight, void* self) {
    const Scene& scene = static_cast<ArkodeIntegrator*>(self)->scene();
    return error_weights(scene, values(y), values(weight)) ? 0 : -1;
  });
  if (implicit) {
    ARKStepSetTableNum(arkode_, ARKODE_TRBDF2_3_3_2, ARKODE_ERK_NONE);
    set_implicit_options();
  } else {
    ARKStepSetTableNum(arkode_, ARKODE_DIRK_NONE, ARKODE_ARK436L2SA_ERK_6_3_4);
  }
  const TimeCase& options = scene().source.time;
  ARKStepSetMinStep(arkode_, shortest_step());
  if (options.maximum_step) ARKStepSetMaxStep(arkode_, *options.maximum_step);
  ARKStepSetMaxErrTestFails(arkode_, 40);
  ARKStepSetMaxConvFails(arkode_, 40);
}

void ArkodeIntegrator::set_implicit_options() {
  newton_iteration_ = SUNNonlinSol_Newton(y_, context_);
  ARKStepSetNonlinearSolver(arkode_, newton_iteration_);
  newton_solver_ = make_newton_solver(dynamics(),
                                      {.gamma =
                                           [this] {
                                             double gamma = 0;
                                             ARKStepGetCurrentGamma(arkode_, &gamma);
                                             return gamma;
                                           }},
                                      context_);
  ARKStepSetLinearSolver(arkode_, newton_solver_, nullptr);
  ARKStepSetPreconditioner(
      arkode_,
      [](realtype t, N_Vector y, N_Vector, booleantype, booleantype* is_new, realtype, void* self) {
        *is_new = SUNTRUE;
        static_cast<ArkodeIntegrator*>(self)->dynamics().assemble(t, values(y),
                                                                  Definiteness::semi_definite);
        return 0;
      },
      nullptr);
  // Every step gets a new matrix (docs/decisions/0007).
  ARKStepSetLSetupFrequency(arkode_, 1);
  ARKStepSetEpsLin(arkode_, linear_tolerance_factor);
  // ARKODE deduces the rate of a stage from its solution. If it evaluated the forces again, the
  // evaluation could fail and end the run.
  ARKStepSetDeduceImplicitRhs(arkode_, SUNTRUE);
  // Stages start from the interpolant of the last step (docs/decisions/0014).
  ARKStepSetPredictorMethod(arkode_, 1);
}

void ArkodeIntegrator::destroy() {
  ARKStepFree(&arkode_);
  if (newton_iteration_ != nullptr) SUNNonlinSolFree(newton_iteration_);
  newton_iteration_ = nullptr;
  if (newton_solver_ != nullptr) SUNLinSolFree(newton_solver_);
  newton_solver_ = nullptr;
}

OneStepIntegrator::Trouble ArkodeIntegrator::attempt(double& end, std::span<double> y) {
  if (!scene().source.contact.enabled) reconsider();
  if (arkode_time_ != time()) {
    std::copy(state().begin(), state().end(), values(y_).begin());
    ARKStepReset(arkode_, time(), y_);
    ARKStepSetInitStep(arkode_, end - time());
    was_stopped_ = false;
  }
  ARKStepSetMinStep(arkode_, shortest_step());
  if (motions_limit_steps() && !set_stop_time(end)) return Trouble::unstable;
  fault_in_step_.reset();
  // In this mode ARKODE returns after every step. The argument time() + 1 only gives the direction.
  const int flag = ARKStepEvolve(arkode_, time() + 1, y_, &arkode_time_, ARK_ONE_STEP);
  if (flag < 0) return trouble_of(flag, end);
  was_stopped_ = flag == ARK_TSTOP_RETURN;
  end = arkode_time_;
  propose(end - time());
  std::copy(values(y_).begin(), values(y_).end(), y.begin());
  note_error();
  return Trouble::none;
}

void ArkodeIntegrator::note_error() {
  N_Vector error = N_VClone(y_), weight = N_VClone(y_);
  ARKStepGetEstLocalErrors(arkode_, error);
  ARKStepGetErrWeights(arkode_, weight);
  N_VProd(error, weight, error);
  set_error_limit(largest_error_part(dynamics(), values(error)));
  N_VDestroy(error);
  N_VDestroy(weight);
}

// Sets ARKODE's stop time to the latest end that motions allow. Returns false if no step is short
// enough. ARKODE's own next step may end after `end`. The motion limits therefore apply to the
// later of these two times.
bool ArkodeIntegrator::set_stop_time(double end) {
  double next = 0;
  ARKStepGetCurrentStep(arkode_, &next);
  const double length = was_stopped_ ? longest_step_after_stop(last_step())
                        : next > 0   ? MotionLimits::beyond_rounding * next
                                     : longest_first_step;
  const double wanted = std::max(end, time() + length);
  const auto latest = latest_end(wanted);
  if (!latest) return false;
  ARKStepSetStopTime(arkode_, was_stopped_ ? *latest : MotionLimits::stop_time(*latest, wanted));
  return true;
}

// Returns the trouble of a failed ARKODE step. If the forces could not be evaluated, `end` becomes
// the end of ARKODE's last trial. Otherwise ARKODE has tried shorter steps itself. `end` then
// becomes time(), which ends the run.
OneStepIntegrator::Trouble ArkodeIntegrator::trouble_of(int flag, double& end) {
  arkode_time_ = std::numeric_limits<double>::quiet_NaN();
  set_fault(fault_in_step_);
  double tried = 0;
  ARKStepGetCurrentStep(arkode_, &tried);
  end = time() + std::min(tried, end - time());
  if (fault_in_step_) {
    return sim::trouble_of(*fault_in_step_);
  }
  set_place(worst_particle(arkode_, y_, ARKStepGetEstLocalErrors, ARKStepGetErrWeights));
  end = time();
  propose(0);
  return flag == ARK_CONV_FAILURE ? Trouble::not_converged : Trouble::error_too_large;
}

// Returns the work done so far, in the unit of work_of().
double ArkodeIntegrator::work() const { return work_of(dynamics(), counts().linear_iterations); }

// Chooses between implicit and explicit steps. Explicit steps take over if their predicted cost is
// well below the measured cost of implicit steps. If stability limits explicit steps, implicit
// steps are tried again after a number of steps that doubles each time.
void ArkodeIntegrator::reconsider() {
  const std::int64_t steps = OneStepIntegrator::counts().steps - steps_at_comparison_;
  if (steps < (implicit_ ? measured_steps : explicit_steps_)) return;
  const double elapsed = time() - time_at_comparison_;
  const double mean_step = elapsed / static_cast<double>(steps);
  if (!implicit_ || last_step() < growing * mean_step) {
    const double rate = estimate_spectrum(dynamics(), time(), state()).stiffest();
    if (implicit_) {
      const double cost = (work() - work_at_comparison_) / elapsed;
      const double explicit_cost = dynamics().evaluation_work() * explicit_stages *
                                   std::max(rate / explicit_limit, 1 / mean_step);
      if (explicit_cost < worthwhile * cost) use(false, rate, explicit_cost / cost);
    } else if (mean_step * rate > 0.5 * explicit_limit) {
      explicit_steps_ *= 2;
      use(true, rate, 0);
    }
  }
  steps_at_comparison_ = OneStepIntegrator::counts().steps;
  work_at_comparison_ = work();
  time_at_comparison_ = time();
}

// Returns counts() without the failures that OneStepIntegrator counts.
IntegratorCounts ArkodeIntegrator::counts_of_solvers() const {
  const IntegratorCounts own = OneStepIntegrator::counts();
  IntegratorCounts all = counts();
  all.error_test_failures -= own.error_test_failures;
  all.convergence_failures -= own.convergence_failures;
  return all;
}

void ArkodeIntegrator::transfer(StateArchive& archive) {
  IntegratorCounts so_far = counts_of_solvers();
  transfer_steps(archive);
  bool implicit = implicit_;
  double next = 0;
  ARKStepGetCurrentStep(arkode_, &next);
  archive(so_far, implicit, next, decision_, steps_at_comparison_, explicit_steps_,
          work_at_comparison_, time_at_comparison_);
  if (!archive.reads()) return;
  destroy();
  create(implicit);
  ARKStepSetInitStep(arkode_, next > 0 ? next : first_step(dynamics(), time(), state()));
  earlier_ = so_far;
}

void ArkodeIntegrator::use(bool implicit, double rate, double part_of_cost) {
  earlier_ = counts_of_solvers();
  destroy();
  create(implicit);
  ARKStepSetInitStep(arkode_, last_step());
  const std::string when = " Runge-Kutta steps from t = " + rounded_text(time()) + " s: ";
  const std::string fastest = "the fastest rate is " + rounded_text(rate) + " /s";
  decision_ = implicit ? "implicit" + when + fastest + ", and holds explicit ones back"
                       : "explicit" + when + "at a fastest rate of " + rounded_text(rate) +
                             " /s they should cost " + number_text(std::round(100 * part_of_cost)) +
                             " % of implicit ones";
}

}  // namespace

std::unique_ptr<Integrator> make_arkode_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<ArkodeIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
