#include "sim/modes/case_equilibrium.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/case/case_error.h"
#include "sim/case/time_methods.h"
#include "sim/motion/dynamics.h"
#include "sim/run/initial_state.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_curves.h"
#include "sim/simulation/cpu_limit.h"

namespace weft::sim {

namespace {

// A start shape is in balance if the norm of its forces is at most `balanced_part` of the norm of
// the loads and of the forces on held particles. It is also in balance if no force, acting alone,
// would move its particle by more than `balanced_move_part` of the size of the bodies, beyond the
// force that rounded positions may cause: `position_roundings` roundings of the coordinates, times
// the largest stiffness of the particle in any direction. Across the plane of flat cloth, the
// stiffness itself is a rounding error.
constexpr double balanced_part = 1e-8, balanced_move_part = 1e-12, position_roundings = 8;

void refuse_timed_pins(const Case& source) {
  for (const BodyCase& body : source.body) {
    for (const PinCase& pin : body.pin) {
      if (pin.hold_time == 0 && !pin.release_time) continue;
      throw CaseError(pin.location, "a pin that takes hold or lets go in time has no part in modes",
                      "expected a pin that always holds");
    }
  }
}

bool moves(const std::optional<MotionCase>& motion) { return motion.has_value(); }

// True if the case has curves, moving pins, moving obstacles or seams that close.
bool changes(const Case& source) {
  const auto has_moving_pin = [](const BodyCase& body) {
    return std::ranges::any_of(body.pin, [](const PinCase& pin) { return moves(pin.motion); });
  };
  const auto closes = [](const SeamCase& seam) { return seam.closing_time > 0; };
  return !find_curves(source).empty() || std::ranges::any_of(source.body, has_moving_pin) ||
         std::ranges::any_of(source.seam, closes) ||
         std::ranges::any_of(source.obstacle,
                             [](const ObstacleCase& each) { return moves(each.motion); });
}

// Returns the case with the options of a search for its equilibrium at time.duration.
Case equilibrium_case(Case source, const EquilibriumOptions& options) {
  refuse_particles(source);
  refuse_timed_pins(source);
  for (TieCase& tie : source.tie) tie.break_force.reset();
  const bool finds_equilibria = traits_of(source.time.method).finds_equilibria();
  const bool follows_path = finds_equilibria && !options.start_shape && !options.load_factor &&
                            source.equilibria.loading == Loading::arc_length;
  TimeCase time;
  time.method = TimeMethod::static_loads;
  time.duration = source.time.duration;
  time.frames_per_second = source.time.frames_per_second;
  time.position_tolerance = source.time.position_tolerance;
  time.minimum_step = source.time.minimum_step;
  time.preconditioner = source.time.preconditioner;
  if (!follows_path) {
    source.equilibria.loading = Loading::in_time;
    if (!changes(source)) time.frames_per_second = 1 / time.duration;
  }
  source.time = time;
  source.output.velocity = source.output.step_energies = false;
  source.output.channels.clear();
  return source;
}

std::unique_ptr<const Scene> checked_scene(const Case& source) {
  auto scene = build_scene(source);
  check_initial_state(*scene);
  return scene;
}

double norm(std::span<const Vec3> vectors) {
  double sum = 0;
  for (const Vec3& each : vectors) sum += each.squaredNorm();
  return std::sqrt(sum);
}

// `force` holds the net force (N) on each dynamic particle, zero for held particles. `left` is the
// norm of `force` (N). `applied` is the norm (N) of the loads and of the forces on held particles.
struct Balance {
  std::vector<Vec3> force;
  double left = 0, applied = 0;
};
std::optional<Balance> find_balance(Dynamics& dynamics, double time, std::span<const double> y) {
  const Scene& scene = dynamics.scene();
  std::vector<Vec3> force(dynamics.particle_count()), applied(dynamics.particle_count()), held;
  if (dynamics.net_forces(time, y, force)) return std::nullopt;
  dynamics.applied_loads(time, y, true, applied);
  for (std::size_t i = 0; i < force.size(); ++i) {
    if (scene.pinned[i] == 0) continue;
    held.push_back(force[i]);
    force[i].setZero();
  }
  const double left = norm(force), all = std::hypot(norm(applied), norm(held));
  return Balance{std::move(force), left, all};
}

double size_of(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (int i = 0; i < scene.dynamic_particles; ++i) box.extend(scene.initial_position[i]);
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

}  // namespace

void refuse_particles(const Case& source) {
  if (source.particles.empty()) return;
  throw CaseError(source.particles.front().location, "particles have no part in modes",
                  "expected a case of bodies");
}

CaseEquilibrium::CaseEquilibrium(const Case& source, EquilibriumOptions options)
    : options_(std::move(options)),
      scene_(checked_scene(equilibrium_case(source, options_))),
      simulation_(*scene_) {
  apply_load_factor();
  state_ = start_at(0);
}

CaseEquilibrium::~CaseEquilibrium() = default;

void CaseEquilibrium::apply_load_factor() {
  if (!options_.load_factor) return;
  dynamics().set_load_factor(*options_.load_factor);
  if (scene_->source.equilibria.scale_gravity) dynamics().set_load(*options_.load_factor);
}

// Returns the start shape at rest, with moving pins at their positions at `time`.
std::vector<double> CaseEquilibrium::start_at(double time) const {
  std::vector<double> y = dynamics().initial_state();
  dynamics().place_pins(time, y);
  std::fill(y.begin() + static_cast<std::ptrdiff_t>(y.size() / 2), y.end(), 0.0);
  return y;
}

bool CaseEquilibrium::starts_in_balance(double time, std::span<const double> y) {
  if (scene_->source.equilibria.loading == Loading::arc_length) return false;
  const std::optional<Balance> balance = find_balance(dynamics(), time, y);
  if (!balance) return false;
  if (!std::isfinite(balance->applied)) return false;
  if (balance->left <= balanced_part * balance->applied) return true;
  dynamics().assemble(time, y);
  const std::span<const Vec3> position = StateView::of(y).position;
  const double farthest = balanced_move_part * size_of(*scene_);
  for (int i = 0; i < dynamics().particle_count(); ++i) {
    const Vec3 stiffness = dynamics().stiffness().diagonal_block(i).diagonal().cwiseMax(0);
    const double rounding = position_roundings * std::numeric_limits<double>::epsilon() *
                            position[i].norm() * stiffness.maxCoeff();
    const auto force = balance->force[i].cwiseAbs().array();
    if ((force > farthest * stiffness.array() + rounding).any()) return false;
  }
  return true;
}

std::optional<Failure> CaseEquilibrium::find() {
  if (options_.start_shape) return std::nullopt;
  const double end = scene_->source.time.duration;
  std::vector<double> start = start_at(end);
  if (starts_in_balance(end, start)) {
    time_ = end;
    state_ = std::move(start);
    return std::nullopt;
  }
  CpuLimit limit(
      scene_->source.compute.cpu_limit.value_or(std::numeric_limits<double>::infinity()));
  simulation_.set_reason_to_stop([&]() -> std::optional<Failure> {
    if (!limit.is_passed()) return std::nullopt;
    return limit.failure(simulation_);
  });
  std::optional<Failure> failure;
  while (!failure && simulation_.time() < end && !simulation_.has_ended()) {
    failure = simulation_.step();
    if (options_.progress) options_.progress(simulation_.time());
  }
  simulation_.set_reason_to_stop({});
  time_ = simulation_.time();
  state_.assign(simulation_.state().begin(), simulation_.state().end());
  return failure;
}

double CaseEquilibrium::imbalance() {
  const std::optional<Balance> balance = find_balance(dynamics(), time_, state_);
  if (!balance) return std::numeric_limits<double>::infinity();
  return balance->left == 0 ? 0 : balance->left / balance->applied;
}

}  // namespace weft::sim
