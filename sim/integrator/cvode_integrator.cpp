#include "sim/integrator/cvode_integrator.h"

#include <cvode/cvode.h>
#include <cvode/cvode_ls.h>
#include <cvode/cvode_proj.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "sim/integrator/accepted_step.h"
#include "sim/integrator/first_step.h"
#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/newton_solver.h"
#include "sim/integrator/short_steps.h"
#include "sim/integrator/step_failures.h"
#include "sim/integrator/sundials_access.h"
#include "sim/integrator/vector_operations.h"
#include "sim/integrator/veto_window.h"
#include "sim/motion/motion_limits.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

namespace {

// Tolerance of the Newton iteration as a fraction of the error allowed in a step.
// `newton_tolerance` is CVODE's default. `tight_newton_tolerance` applies for `tight_steps` steps
// after find_swing() has found an alternating error.
constexpr double newton_tolerance = 0.1, tight_newton_tolerance = 0.03;
constexpr int tight_steps = 10;
// `exact_newton_tolerance` applies while the root mean square of the velocities is below
// `speed_near_rest` times their absolute tolerance. The errors that Newton's iteration may leave in
// a step are then no longer small beside the motion, and feed it (docs/decisions/0103).
constexpr double exact_newton_tolerance = 0.01, speed_near_rest = 10;
// `exact_newton_tolerance` applies for `wary_steps` steps, too, after the energy has risen unfed
// (docs/decisions/0109).
constexpr int wary_steps = 100;
// An error alternates if the cosine of the angle between the errors of two successive steps is
// below this value, and the step does not grow.
constexpr double swing_cosine = -0.95;

// Largest number of steps that share a matrix. The number in use grows by one after `smooth_steps`
// successive smooth steps and is halved after a step that is not smooth (docs/decisions/0007). A
// smooth step takes at most `smooth_iterations` Newton iterations without a failure of convergence.
constexpr int longest_interval = 20;
constexpr int smooth_steps = 5;
constexpr int smooth_iterations = 3;

// Largest number of times that contact may reject a step. Each rejection makes the step four times
// shorter. Any sensible time.minimum_step is reached long before.
constexpr int most_vetoes_of_a_step = 40;

// Largest number of vetoes per window; more vetoes end the run.
constexpr int most_vetoes = VetoWindow::length;

}  // namespace

struct CvodeIntegrator::Implementation {
  Implementation(const Scene& scene_, Dynamics& dynamics_)
      : scene(scene_),
        dynamics(dynamics_),
        motion_limits(scene_, dynamics_),
        accepted(dynamics_),
        short_steps(scene_.source.time) {}
  ~Implementation() {
    CVodeFree(&cvode);
    if (newton_iteration != nullptr) SUNNonlinSolFree(newton_iteration);
    if (newton_solver != nullptr) SUNLinSolFree(newton_solver);
    for (N_Vector v : {y, work, step_error, previous_step_error}) {
      if (v != nullptr) N_VDestroy(v);
    }
    SUNContext_Free(&context);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void create();
  void set_options();
  int rate(double t, N_Vector state, N_Vector out);
  int assemble(double t, N_Vector state);
  void choose_matrix_interval();
  void find_swing();
  void take_census();
  std::optional<Failure> follow_motions();
  void begin_anew();
  void begin_without_history();
  bool is_near_rest() const;
  void set_newton_tolerance();
  IntegratorCounts counts() const;
  long convergence_failures() const { return count(CVodeGetNumNonlinSolvConvFails) + unsettled; }
  int veto(double t, N_Vector state);
  void accept(double t);
  Failure failure(int flag) const;
  std::optional<Failure> too_many_vetoes();
  long count(int (*get)(void*, long*)) const { return counter_of(cvode, get); }

  const Scene& scene;
  Dynamics& dynamics;
  MotionLimits motion_limits;
  SUNContext context = nullptr;
  void* cvode = nullptr;
  N_Vector y = nullptr, work = nullptr;
  // Local errors of the last two steps, multiplied by the error weights.
  N_Vector step_error = nullptr, previous_step_error = nullptr;
  SUNNonlinearSolver newton_iteration = nullptr;
  NewtonAttempts attempts;
  SUNLinearSolver newton_solver = nullptr;
  double time = 0;  // time that CVODE has reached (s)
  AcceptedStep accepted;
  ShortSteps short_steps;
  std::int64_t vetoes = 0, restarts = 0;
  // Number of rejections by most_gap_change since CVODE was last reinitialised.
  long unsettled = 0;
  IntegratorCounts earlier;  // counts before CVODE was last reinitialised
  // Number of steps that share a matrix, and number of smooth steps counted towards its growth.
  int matrix_interval = 1, smooth_steps_so_far = 0;
  long iterations_before_step = 0, failures_before_step = 0;
  int tight_steps_left = 0, wary_steps_left = 0;
  std::int64_t vetoes_before_step = 0;
  StepCensus census;
  // True if the last step ended at CVODE's stop time. CVodeGetCurrentStep() then does not return
  // the length of the next step but an earlier one, which may be much shorter.
  bool was_stopped = false;
  bool has_last_step = false;  // true if CVODE can interpolate within the last step
  VetoWindow veto_window;
  std::optional<ContactFault> last_fault;
};

void CvodeIntegrator::Implementation::create() {
  SUNContext_Create(nullptr, &context);
  const auto size = static_cast<sunindextype>(dynamics.state_size());
  y = make_vector(size, dynamics.threads(), context);
  work = N_VClone(y);
  step_error = N_VClone(y);
  previous_step_error = N_VClone(y);
  N_VConst(0, step_error);
  std::copy(accepted.state().begin(), accepted.state().end(), values(y).begin());
  cvode = CVodeCreate(CV_BDF, context);
  CVodeInit(
      cvode,
      [](realtype t, N_Vector state, N_Vector out, void* self) {
        return static_cast<Implementation*>(self)->rate(t, state, out);
      },
      0.0, y);
  set_options();
}

void CvodeIntegrator::Implementation::set_options() {
  const TimeCase& options = scene.source.time;
  CVodeSetUserData(cvode, this);
  // CVODE's own messages are discarded: step() reports failures in Weft's terms.
  CVodeSetErrHandlerFn(
      cvode, [](int, const char*, const char*, char*, void*) {}, nullptr);
  CVodeWFtolerances(cvode, [](N_Vector state, N_Vector weight, void* self) {
    const Scene& scene = static_cast<Implementation*>(self)->scene;
    return error_weights(scene, values(state), values(weight)) ? 0 : -1;
  });
  CVodeSetMaxOrd(cvode, options.maximum_order);
  CVodeSetMinStep(cvode, short_steps.shortest());
  if (options.maximum_step) CVodeSetMaxStep(cvode, *options.maximum_step);
  CVodeSetMaxNumSteps(cvode, std::numeric_limits<int>::max());
  CVodeSetMaxConvFails(cvode, 40);
  CVodeSetMaxErrTestFails(cvode, 40);
  CVodeSetInitStep(cvode, first_step(dynamics, 0, accepted.state()));
  newton_iteration = SUNNonlinSol_Newton(y, context);
  CVodeSetNonlinearSolver(cvode, newton_iteration);
  set_newton_tolerance();
  newton_solver = make_newton_solver(dynamics,
                                     {.gamma =
                                          [this] {
                                            double gamma = 0;
                                            CVodeGetCurrentGamma(cvode, &gamma);
                                            return gamma;
                                          }},
                                     context);
  CVodeSetLinearSolver(cvode, newton_solver, nullptr);
  CVodeSetPreconditioner(
      cvode,
      [](realtype t, N_Vector state, N_Vector, booleantype, booleantype* is_new, realtype,
         void* self) {
        *is_new = SUNTRUE;
        return static_cast<Implementation*>(self)->assemble(t, state);
      },
      nullptr);
  CVodeSetEpsLin(cvode, linear_tolerance_factor);
  CVodeSetLSetupFrequency(cvode, matrix_interval);
  if (dynamics.contact() == nullptr && !dynamics.has_limits()) return;
  CVodeSetProjFn(
      cvode, [](realtype t, N_Vector state, N_Vector correction, realtype, N_Vector, void* self) {
        N_VConst(0, correction);
        return static_cast<Implementation*>(self)->veto(t, state);
      });
  CVodeSetProjErrEst(cvode, SUNFALSE);
  CVodeSetProjFrequency(cvode, 1);
  CVodeSetMaxNumProjFails(cvode, most_vetoes_of_a_step);
  CVodeSetProjFailEta(cvode, 0.25);
}

int CvodeIntegrator::Implementation::rate(double t, N_Vector state, N_Vector out) {
  attempts.note_iterate(t, dynamics);
  auto fault = dynamics.rate(t, values(state), values(out));
  if (!fault) return 0;
  last_fault = fault;
  return 1;  // a recoverable error: CVODE shortens the step
}

// Assembles the stiffness K and the damping D even if CVODE could reuse the last ones with a new
// gamma (docs/decisions/0007). They are semi-definite: the Newton iteration then converges in long
// steps, too, whose exact matrix is indefinite (docs/decisions/0006).
int CvodeIntegrator::Implementation::assemble(double t, N_Vector state) {
  dynamics.assemble(t, values(state), Definiteness::semi_definite);
  return 0;
}

// Adds the last step to the census. To be called after find_swing(), which forms the weighted
// error, and before choose_matrix_interval(), which counts the failures of the step.
void CvodeIntegrator::Implementation::take_census() {
  StepLimit limit = StepLimit::given;
  if (vetoes != vetoes_before_step) {
    limit = StepLimit::surfaces;
  } else if (convergence_failures() != failures_before_step) {
    limit = StepLimit::convergence;
  } else {
    limit = largest_error_part(dynamics, values(step_error));
  }
  vetoes_before_step = vetoes;
  census.add(accepted.time() - accepted.start_time(), limit);
}

void CvodeIntegrator::Implementation::choose_matrix_interval() {
  const long iterations = count(CVodeGetNumNonlinSolvIters);
  const long failures = convergence_failures();
  const bool is_smooth =
      failures == failures_before_step && iterations - iterations_before_step <= smooth_iterations;
  iterations_before_step = iterations;
  failures_before_step = failures;
  if (!is_smooth) {
    smooth_steps_so_far = 0;
    matrix_interval = std::max(1, matrix_interval / 2);
  } else if (++smooth_steps_so_far == smooth_steps) {
    smooth_steps_so_far = 0;
    matrix_interval = std::min(longest_interval, matrix_interval + 1);
  }
  CVodeSetLSetupFrequency(cvode, matrix_interval);
}

// Tightens the Newton iteration if the local error changes sign from step to step
// (docs/decisions/0005). Such an error comes from the Newton iteration, and a shorter step does not
// reduce it. Errors of smooth motions are similar in successive steps, and errors of stiff motions
// decay.
void CvodeIntegrator::Implementation::find_swing() {
  std::swap(step_error, previous_step_error);
  CVodeGetEstLocalErrors(cvode, step_error);
  CVodeGetErrWeights(cvode, work);
  N_VProd(step_error, work, step_error);
  double last = 0, next = 0;
  CVodeGetLastStep(cvode, &last);
  CVodeGetCurrentStep(cvode, &next);
  const auto is_opposed = [&] {
    const double product = N_VDotProd(step_error, previous_step_error);
    return product < 0 &&
           product < swing_cosine * std::sqrt(N_VDotProd(step_error, step_error) *
                                              N_VDotProd(previous_step_error, previous_step_error));
  };
  const bool swings = next <= last && is_opposed();
  tight_steps_left = swings ? tight_steps : std::max(0, tight_steps_left - 1);
  set_newton_tolerance();
}

// True if the root mean square of the accepted velocities is below `speed_near_rest`.
bool CvodeIntegrator::Implementation::is_near_rest() const {
  const auto velocities = accepted.state().subspan(accepted.state().size() / 2);
  double sum = 0;
  for (const double velocity : velocities) sum += velocity * velocity;
  const double limit = speed_near_rest * velocity_tolerance(scene.source.time);
  return sum < limit * limit * static_cast<double>(velocities.size());
}

void CvodeIntegrator::Implementation::set_newton_tolerance() {
  double tolerance = tight_steps_left > 0 ? tight_newton_tolerance : newton_tolerance;
  if (wary_steps_left > 0 || is_near_rest()) tolerance = exact_newton_tolerance;
  CVodeSetNonlinConvCoef(cvode, tolerance);
}

// Tells CVODE the latest end of its next step. Restarts CVODE if a prescribed velocity or a curve
// jumps at the start of that step, because its history is then invalid. Returns a failure if
// motions allow no step.
std::optional<Failure> CvodeIntegrator::Implementation::follow_motions() {
  const double start = accepted.time();
  // After a jump, short steps may end near it again.
  const bool jumps =
      start > 0 && motion_limits.jumps_at(start) && !motion_limits.jumps_at(accepted.start_time());
  if (jumps) begin_anew();
  dynamics.begin_step(start);
  // If coefficients vary, the first step after a jump needs its own length. CVODE would reuse the
  // initial length that was set last.
  if (jumps && dynamics.varies())
    CVodeSetInitStep(cvode, first_step(dynamics, start, accepted.state()));
  double last = 0, next = 0;
  CVodeGetLastStep(cvode, &last);  // 0 after a start
  CVodeGetCurrentStep(cvode, &next);
  const double longest = was_stopped ? longest_step_after_stop(last)
                         : last > 0  ? MotionLimits::beyond_rounding * next
                                     : longest_first_step;
  const double wanted = start + longest;
  const auto end = motion_limits.latest_end(start, wanted, accepted.state());
  if (!end) return motion_limits.failure(start);
  CVodeSetStopTime(cvode, was_stopped ? *end : MotionLimits::stop_time(*end, wanted));
  return std::nullopt;
}

void CvodeIntegrator::Implementation::begin_anew() {
  accepted.place_pins();
  accepted.match_supports();
  std::copy(accepted.state().begin(), accepted.state().end(), values(y).begin());
  earlier = counts();
  unsettled = 0;
  CVodeReInit(cvode, accepted.time(), y);
  was_stopped = false;
  iterations_before_step = failures_before_step = 0;
  has_last_step = false;
}

// Begins anew at the accepted state, with a first step that suits it.
void CvodeIntegrator::Implementation::begin_without_history() {
  time = accepted.time();
  begin_anew();
  CVodeSetInitStep(cvode, first_step(dynamics, time, accepted.state()));
  N_VConst(0, step_error);
  set_newton_tolerance();
}

int CvodeIntegrator::Implementation::veto(double t, N_Vector state) {
  if (dynamics.contact() != nullptr) {
    accepted.place_trial(t, values(state));
    // check_limits() would forget where the forces were evaluated last.
    if (accepted.trial_gap_change(closing_factor) > most_gap_change) {
      ++unsettled;
      return 1;
    }
  }
  auto fault = dynamics.check_limits(t, values(state));
  if (!fault && dynamics.contact() != nullptr) fault = accepted.check_trial_path(t);
  if (!fault) return 0;
  ++vetoes;
  veto_window.add_veto(fault);
  last_fault = fault;
  return 1;
}

// Accepts CVODE's state. It may differ in the last bits from the state that veto() checked, so the
// positions are computed again.
void CvodeIntegrator::Implementation::accept(double t) {
  const std::span<double> end = accepted.begin_trial();
  std::copy(values(y).begin(), values(y).end(), end.begin());
  accepted.place_trial(t, end);
  accepted.accept(t);
  wary_steps_left = std::max(0, wary_steps_left - 1);
  short_steps.note(accepted.time() - accepted.start_time());
  CVodeSetMinStep(cvode, short_steps.shortest());
}

Failure CvodeIntegrator::Implementation::failure(int flag) const {
  const auto pressed = pressed_surfaces(dynamics, accepted.time(), accepted.state());
  const std::optional<ContactFault>& fault = pressed ? pressed : last_fault;
  FailurePlace place{
      .time = accepted.time(), .fault = fault, .may_be_short = short_steps.are_allowed()};
  if (!fault) place.particle = worst_particle(cvode, y, CVodeGetEstLocalErrors, CVodeGetErrWeights);
  switch (flag) {
    case CV_ERR_FAILURE:
      return shortest_step_failure(trouble_with(pressed, StepTrouble::error_too_large), place,
                                   scene);
    case CV_CONV_FAILURE:
      return shortest_step_failure(trouble_with(pressed, StepTrouble::not_converged), place, scene);
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
    case CV_FIRST_RHSFUNC_ERR:
    case CV_RHSFUNC_FAIL: {
      const bool touches = last_fault && last_fault->kind != ContactFault::Kind::not_finite;
      return placed_failure(touches ? Failure::Kind::surfaces : Failure::Kind::not_finite,
                            "the forces cannot be evaluated", place, scene);
    }
    case CV_REPTD_PROJFUNC_ERR:
    case CV_PROJFUNC_FAIL:
      return shortest_step_failure(
          last_fault ? trouble_of(*last_fault) : StepTrouble::not_converged, place, scene);
    default: {
      char* name = CVodeGetReturnFlagName(flag);
      const std::string text = "CVODE stopped with " + std::string(name);
      free(name);
      return placed_failure(Failure::Kind::solver, text, place, scene);
    }
  }
}

std::optional<Failure> CvodeIntegrator::Implementation::too_many_vetoes() {
  const auto recent = veto_window.add_step();
  if (!recent || *recent <= most_vetoes) return std::nullopt;
  return veto_window.failure(
      *recent, accepted.time(),
      "contact.stiffness or contact.damping_time is too small for this impact", scene);
}

CvodeIntegrator::CvodeIntegrator(const Scene& scene, Dynamics& dynamics)
    : implementation_(std::make_unique<Implementation>(scene, dynamics)) {
  implementation_->create();
}

CvodeIntegrator::~CvodeIntegrator() = default;

std::optional<Failure> CvodeIntegrator::step() {
  Implementation& self = *implementation_;
  self.last_fault.reset();
  if (self.motion_limits.apply()) {
    if (auto failure = self.follow_motions()) return failure;
  }
  // In this mode CVODE returns after every step. The argument time + 1 only gives the direction.
  const int flag = CVode(self.cvode, self.time + 1, self.y, &self.time, CV_ONE_STEP);
  if (flag < 0) return self.failure(flag);
  self.was_stopped = flag == CV_TSTOP_RETURN;
  self.accept(self.time);
  self.has_last_step = true;
  self.find_swing();
  self.take_census();
  self.choose_matrix_interval();
  return self.too_many_vetoes();
}

double CvodeIntegrator::time() const { return implementation_->accepted.time(); }

double CvodeIntegrator::last_step() const {
  double step = 0;
  CVodeGetLastStep(implementation_->cvode, &step);
  return step;
}

int CvodeIntegrator::last_order() const {
  int order = 0;
  CVodeGetLastOrder(implementation_->cvode, &order);
  return order;
}

std::span<const double> CvodeIntegrator::state() const { return implementation_->accepted.state(); }

std::optional<Failure> CvodeIntegrator::state_at(double time, std::span<double> y) const {
  Implementation& self = *implementation_;
  const AcceptedStep& accepted = self.accepted;
  assert(time >= accepted.start_time() && time <= accepted.time() &&
         y.size() == accepted.state().size());
  if (!accepted.has_start()) {
    std::copy(accepted.state().begin(), accepted.state().end(), y.begin());
    return std::nullopt;
  }
  if (self.has_last_step) {
    CVodeGetDky(self.cvode, time, 0, self.work);
    std::copy(values(self.work).begin(), values(self.work).end(), y.begin());
  } else {
    accepted.interpolate(time, y, 2);
  }
  return accepted.settle(time, y);
}

void CvodeIntegrator::restart(double time, std::span<const double> y) {
  Implementation& self = *implementation_;
  self.accepted.restart(time, y);
  self.begin_without_history();
  ++self.restarts;
}

void CvodeIntegrator::transfer(StateArchive& archive) {
  Implementation& self = *implementation_;
  IntegratorCounts so_far = self.counts();
  self.accepted.transfer(archive);
  self.veto_window.transfer(archive);
  self.short_steps.transfer(archive);
  archive(so_far, self.vetoes, self.vetoes_before_step, self.census, self.restarts,
          self.matrix_interval, self.smooth_steps_so_far, self.tight_steps_left,
          self.wary_steps_left);
  if (!archive.reads()) return;
  self.begin_without_history();
  CVodeSetMinStep(self.cvode, self.short_steps.shortest());
  self.earlier = so_far;
  CVodeSetLSetupFrequency(self.cvode, self.matrix_interval);
}

void CvodeIntegrator::tighten() {
  Implementation& self = *implementation_;
  self.wary_steps_left = wary_steps;
  self.set_newton_tolerance();
}

IntegratorCounts CvodeIntegrator::counts() const { return implementation_->counts(); }

IntegratorCounts CvodeIntegrator::Implementation::counts() const {
  IntegratorCounts counts;
  counts.steps = earlier.steps + count(CVodeGetNumSteps);
  counts.vetoed_steps = vetoes;
  counts.error_test_failures = earlier.error_test_failures + count(CVodeGetNumErrTestFails);
  counts.convergence_failures = earlier.convergence_failures + convergence_failures();
  counts.newton_iterations = earlier.newton_iterations + count(CVodeGetNumNonlinSolvIters);
  counts.linear_iterations = earlier.linear_iterations + count(CVodeGetNumLinIters);
  counts.linear_setups = earlier.linear_setups + count(CVodeGetNumLinSolvSetups);
  counts.restarts = restarts;
  counts.census = census;
  return counts;
}

std::unique_ptr<Integrator> make_cvode_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<CvodeIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
