#include "sim/integrator/cvode_integrator.h"

#include <cvode/cvode.h>
#include <cvode/cvode_ls.h>
#include <cvode/cvode_proj.h>
#include <nvector/nvector_serial.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "sim/case/case_text.h"
#include "sim/integrator/first_step.h"
#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/newton_solver.h"
#include "sim/integrator/settled_frame.h"
#include "sim/integrator/vector_operations.h"
#include "sim/motion/motion_limits.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

namespace {

// The motion limits are asked for a step that is longer by this factor, so that rounding shortens
// no step that they allow in full.
constexpr double beyond_rounding = 1.0001;

std::span<double> values(N_Vector v) {
  return {NV_DATA_S(v), static_cast<std::size_t>(NV_LENGTH_S(v))};
}

// CVODE's tolerance of the linear solve, as a fraction of the Newton tolerance; its default, 0.05,
// takes a third longer for the same error.
constexpr double linear_tolerance_factor = 0.3;

// Newton tolerance as a fraction of the error allowed in a step. The first is CVODE's default; the
// second holds for `tight_steps` steps after errors that swing (find_swing).
constexpr double newton_tolerance = 0.1, tight_newton_tolerance = 0.03;
constexpr int tight_steps = 10;
// The errors of two steps swing where the cosine of the angle between them is below this.
constexpr double swing_cosine = -0.95;

// Largest number of steps with one matrix. CVODE notices an outdated matrix by a Newton iteration
// that fails, which costs more than a new matrix. The number therefore grows by one after
// `smooth_steps` smooth steps and is halved after a step that was not smooth. A smooth step takes
// at most `smooth_iterations` Newton iterations, none of which fails.
constexpr int longest_interval = 20;
constexpr int smooth_steps = 5;
constexpr int smooth_iterations = 3;

// A step refused this often because of contact, each time with a quarter of the length, is
// impossible. (The shortest step is reached long before, for any sensible time.minimum_step.)
constexpr int most_vetoes_of_a_step = 40;

// Steps over which vetoes are counted, and the count that ends a run.
constexpr int veto_window = 200;

}  // namespace

struct CvodeIntegrator::Implementation {
  Implementation(const Scene& scene_, Dynamics& dynamics_)
      : scene(scene_), dynamics(dynamics_), motion_limits(scene_, dynamics_) {}
  ~Implementation() {
    CVodeFree(&cvode);
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
  std::optional<Failure> follow_motions();
  void begin_anew();
  IntegratorCounts counts() const;
  int veto(double t, N_Vector state);
  void accept(double t);
  int worst_place() const;
  Failure failure(int flag) const;
  std::optional<Failure> too_many_vetoes();
  long count(int (*get)(void*, long*)) const {
    long value = 0;
    get(cvode, &value);
    return value;
  }

  const Scene& scene;
  Dynamics& dynamics;
  MotionLimits motion_limits;
  SUNContext context = nullptr;
  void* cvode = nullptr;
  N_Vector y = nullptr, work = nullptr;
  // The local errors of the last two steps, by their weights.
  N_Vector step_error = nullptr, previous_step_error = nullptr;
  SUNLinearSolver newton_solver = nullptr;
  double time = 0;
  std::vector<double> accepted_state;
  std::vector<Vec3> previous_position, accepted_position, trial_position, scratch_velocity;
  double accepted_time = 0, previous_time = 0;
  std::vector<double> previous_state;
  std::int64_t vetoes = 0, restarts = 0;
  IntegratorCounts earlier;                          // what CVODE counted before it began anew
  int matrix_interval = 1, smooth_steps_so_far = 0;  // steps
  long iterations_before_step = 0, failures_before_step = 0;
  int tight_steps_left = 0;
  int steps_in_window = 0;
  std::int64_t vetoes_before_window = 0;
  std::optional<ContactFault> last_fault, last_veto;
};

void CvodeIntegrator::Implementation::create() {
  SUNContext_Create(nullptr, &context);
  const auto size = static_cast<sunindextype>(dynamics.state_size());
  y = make_vector(size, dynamics.threads(), context);
  work = N_VClone(y);
  step_error = N_VClone(y);
  previous_step_error = N_VClone(y);
  N_VConst(0, step_error);
  accepted_state = dynamics.initial_state();
  previous_state = accepted_state;
  std::copy(accepted_state.begin(), accepted_state.end(), values(y).begin());
  dynamics.expand(0, accepted_state, accepted_position, scratch_velocity);
  previous_position = trial_position = accepted_position;
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
  // CVODE's own messages are discarded: step() reports failures in our words.
  CVodeSetErrHandlerFn(
      cvode, [](int, const char*, const char*, char*, void*) {}, nullptr);
  CVodeWFtolerances(cvode, [](N_Vector state, N_Vector weight, void* self) {
    const TimeCase& time_case = static_cast<Implementation*>(self)->scene.source.time;
    return error_weights(time_case, values(state), values(weight)) ? 0 : -1;
  });
  CVodeSetMaxOrd(cvode, options.maximum_order);
  CVodeSetMinStep(cvode, options.minimum_step);
  if (options.maximum_step) CVodeSetMaxStep(cvode, *options.maximum_step);
  CVodeSetMaxNumSteps(cvode, std::numeric_limits<int>::max());
  CVodeSetMaxConvFails(cvode, 40);
  CVodeSetMaxErrTestFails(cvode, 40);
  CVodeSetInitStep(cvode, first_step(dynamics, accepted_state));
  CVodeSetNonlinConvCoef(cvode, newton_tolerance);
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
  if (dynamics.contact() == nullptr) return;
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
  auto fault = dynamics.rate(t, values(state), values(out));
  if (!fault) return 0;
  last_fault = fault;
  return 1;  // recoverable: CVODE cuts the step
}

// Assembles new K and D wherever CVODE would reuse older ones with a new gamma: the iterations that
// old matrices cost are dearer. Without directions of negative stiffness, the Newton iteration also
// converges where steps are long and the exact matrix is indefinite.
int CvodeIntegrator::Implementation::assemble(double t, N_Vector state) {
  dynamics.assemble(t, values(state), Definiteness::semi_definite);
  return 0;
}

void CvodeIntegrator::Implementation::choose_matrix_interval() {
  const long iterations = count(CVodeGetNumNonlinSolvIters);
  const long failures = count(CVodeGetNumNonlinSolvConvFails);
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

// On a smooth motion the errors of successive steps resemble each other; on a stiff one they die
// out. Errors that change sign from step to step are those of Newton's iteration (docs/theory.md,
// section 2). They do not shrink with the step and can hold steps at microseconds and order 1 for
// thousands of steps. A tighter iteration ends that.
void CvodeIntegrator::Implementation::find_swing() {
  std::swap(step_error, previous_step_error);
  CVodeGetEstLocalErrors(cvode, step_error);
  CVodeGetErrWeights(cvode, work);
  N_VProd(step_error, work, step_error);
  double last = 0, next = 0;
  CVodeGetLastStep(cvode, &last);
  CVodeGetCurrentStep(cvode, &next);
  const double both = std::sqrt(N_VDotProd(step_error, step_error) *
                                N_VDotProd(previous_step_error, previous_step_error));
  const bool swings =
      next <= last && N_VDotProd(step_error, previous_step_error) < swing_cosine * both;
  tight_steps_left = swings ? tight_steps : std::max(0, tight_steps_left - 1);
  CVodeSetNonlinConvCoef(cvode, tight_steps_left > 0 ? tight_newton_tolerance : newton_tolerance);
}

// Tells CVODE where its next step must end, and where what it knows of the past is of no use.
std::optional<Failure> CvodeIntegrator::Implementation::follow_motions() {
  if (accepted_time > 0 && motion_limits.jumps_at(accepted_time)) begin_anew();
  dynamics.begin_step(accepted_time);
  double next = 0;
  CVodeGetCurrentStep(cvode, &next);
  const double wanted =
      accepted_time + (next > 0 ? beyond_rounding * next : scene.source.time.duration);
  const auto end = motion_limits.latest_end(accepted_time, wanted, accepted_state);
  if (!end) return motion_limits.failure(accepted_time);
  // CVODE cuts the step after the next one by this time, too: one that is not reached is put far
  // off.
  CVodeSetStopTime(cvode, *end < wanted ? *end : std::numeric_limits<double>::max());
  return std::nullopt;
}

void CvodeIntegrator::Implementation::begin_anew() {
  dynamics.place_pins(accepted_time, accepted_state);
  std::copy(accepted_state.begin(), accepted_state.end(), values(y).begin());
  earlier = counts();
  CVodeReInit(cvode, accepted_time, y);
  iterations_before_step = failures_before_step = 0;
}

int CvodeIntegrator::Implementation::veto(double t, N_Vector state) {
  dynamics.expand(t, values(state), trial_position, scratch_velocity);
  auto fault = dynamics.check_path(accepted_time, accepted_position, t, trial_position);
  if (!fault) return 0;
  ++vetoes;
  last_veto = fault;
  last_fault = fault;
  return 1;
}

void CvodeIntegrator::Implementation::accept(double t) {
  previous_time = accepted_time;
  accepted_time = t;
  previous_state.swap(accepted_state);
  std::copy(values(y).begin(), values(y).end(), accepted_state.begin());
  previous_position.swap(accepted_position);
  dynamics.expand(t, accepted_state, accepted_position, scratch_velocity);
}

// Returns the particle whose local error weighs most in the step that failed.
int CvodeIntegrator::Implementation::worst_place() const {
  N_Vector error = N_VClone(y), weight = N_VClone(y);
  CVodeGetEstLocalErrors(cvode, error);
  CVodeGetErrWeights(cvode, weight);
  const int worst = worst_particle(values(error), values(weight));
  N_VDestroy(error);
  N_VDestroy(weight);
  return worst;
}

Failure CvodeIntegrator::Implementation::failure(int flag) const {
  const int particle = last_fault ? last_fault->nodes[0] : worst_place();
  const std::string at =
      " at t = " + rounded_text(accepted_time) + " s" +
      (last_fault ? ": " + last_fault->describe(scene)
                  : ": the error is largest at " + scene.describe_particle(particle));
  const std::string shortest =
      number_text(scene.source.time.minimum_step) + " s (time.minimum_step)";
  const auto failed = [&](Failure::Kind kind, const std::string& what) {
    return Failure{kind, accepted_time, particle, what + at};
  };
  switch (flag) {
    case CV_ERR_FAILURE:
      return failed(Failure::Kind::error_tolerance,
                    "no step down to " + shortest + " meets the error tolerance");
    case CV_CONV_FAILURE:
      return failed(Failure::Kind::newton,
                    "the Newton iteration does not converge with any step down to " + shortest);
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
    case CV_FIRST_RHSFUNC_ERR:
    case CV_RHSFUNC_FAIL: {
      const bool touches = last_fault && last_fault->kind != ContactFault::Kind::not_finite;
      return failed(touches ? Failure::Kind::surfaces : Failure::Kind::not_finite,
                    "the forces cannot be evaluated");
    }
    case CV_REPTD_PROJFUNC_ERR:
    case CV_PROJFUNC_FAIL:
      return failed(Failure::Kind::surfaces,
                    "no step down to " + shortest + " keeps the surfaces apart");
    default: {
      char* name = CVodeGetReturnFlagName(flag);
      const std::string text = "CVODE stopped with " + std::string(name);
      free(name);
      return failed(Failure::Kind::solver, text);
    }
  }
}

// A healthy run hardly ever cuts a step because of contact. One that keeps doing so creeps on
// without end.
std::optional<Failure> CvodeIntegrator::Implementation::too_many_vetoes() {
  if (++steps_in_window < veto_window) return std::nullopt;
  const std::int64_t recent = vetoes - vetoes_before_window;
  steps_in_window = 0;
  vetoes_before_window = vetoes;
  if (recent <= veto_window) return std::nullopt;
  return Failure{
      Failure::Kind::too_many_cuts, accepted_time, last_veto ? last_veto->nodes[0] : -1,
      number_text(static_cast<double>(recent)) + " steps had to be cut in the last " +
          number_text(veto_window) +
          " to keep surfaces apart at t = " + rounded_text(accepted_time) + " s" +
          (last_veto ? ": " + last_veto->describe(scene) : "") +
          " (contact.stiffness or contact.damping_time is too small for this impact, or a "
          "prescribed motion leaves no room)"};
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
  // The time asked for only tells CVODE the direction; steps end where they fall.
  const int flag = CVode(self.cvode, self.time + 1, self.y, &self.time, CV_ONE_STEP);
  if (flag < 0) return self.failure(flag);
  self.accept(self.time);
  self.choose_matrix_interval();
  self.find_swing();
  return self.too_many_vetoes();
}

double CvodeIntegrator::time() const { return implementation_->accepted_time; }

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

std::span<const double> CvodeIntegrator::state() const { return implementation_->accepted_state; }

std::optional<Failure> CvodeIntegrator::state_at(double time, std::span<double> y) const {
  Implementation& self = *implementation_;
  assert(time >= self.previous_time && time <= self.accepted_time &&
         y.size() == self.accepted_state.size());
  if (self.previous_time == self.accepted_time) {  // after a restart
    std::copy(self.accepted_state.begin(), self.accepted_state.end(), y.begin());
    return std::nullopt;
  }
  CVodeGetDky(self.cvode, time, 0, self.work);
  std::copy(values(self.work).begin(), values(self.work).end(), y.begin());
  const double part = (time - self.previous_time) / (self.accepted_time - self.previous_time);
  return settle_frame(
      self.dynamics, time, part,
      {self.previous_state, self.accepted_state, self.previous_position, self.previous_time}, y,
      self.trial_position, self.scratch_velocity);
}

void CvodeIntegrator::restart(double time, std::span<const double> y) {
  Implementation& self = *implementation_;
  self.time = self.accepted_time = self.previous_time = time;
  std::copy(y.begin(), y.end(), self.accepted_state.begin());
  self.begin_anew();
  self.previous_state = self.accepted_state;
  self.dynamics.expand(time, self.accepted_state, self.accepted_position, self.scratch_velocity);
  self.previous_position = self.accepted_position;
  N_VConst(0, self.step_error);
  ++self.restarts;
}

IntegratorCounts CvodeIntegrator::counts() const { return implementation_->counts(); }

IntegratorCounts CvodeIntegrator::Implementation::counts() const {
  IntegratorCounts counts;
  counts.steps = earlier.steps + count(CVodeGetNumSteps);
  counts.vetoed_steps = vetoes;
  counts.error_test_failures = earlier.error_test_failures + count(CVodeGetNumErrTestFails);
  counts.convergence_failures =
      earlier.convergence_failures + count(CVodeGetNumNonlinSolvConvFails);
  counts.newton_iterations = earlier.newton_iterations + count(CVodeGetNumNonlinSolvIters);
  counts.linear_iterations = earlier.linear_iterations + count(CVodeGetNumLinIters);
  counts.linear_setups = earlier.linear_setups + count(CVodeGetNumLinSolvSetups);
  counts.restarts = restarts;
  return counts;
}

std::unique_ptr<Integrator> make_cvode_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<CvodeIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
