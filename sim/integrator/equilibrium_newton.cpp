#include "sim/integrator/equilibrium_newton.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace weft::sim {

namespace {

// Limits of convergence: largest residual relative to the applied forces, and largest correction
// relative to the size of the bodies.
constexpr double residual_fraction = 1e-8, correction_fraction = 1e-8;
// Largest number of iterations of an ordinary search and of a careful one.
constexpr int most_iterations = 20, most_careful_iterations = 60;
// Number of iterations after which an ordinary search diverges if a correction is longer than the
// first one.
constexpr int trial_iterations = 7;
// Longest correction as a fraction of the size of the bodies. Beyond it, an ordinary search
// diverges and a careful search shortens the correction.
constexpr double longest_correction = 1, longest_careful_correction = 0.2;
constexpr double shortest_fraction = 1e-4;  // smallest fraction of a correction that is tried

}  // namespace

double largest_length(std::span<const Vec3> vectors) {
  double largest = 0;
  for (const Vec3& each : vectors) largest = std::max(largest, each.squaredNorm());
  return std::sqrt(largest);
}

EquilibriumNewton::EquilibriumNewton(const Scene& scene, Dynamics& dynamics)
    : scene_(scene),
      dynamics_(dynamics),
      factors_(dynamics),
      force_(dynamics.particle_count()),
      residual_(dynamics.particle_count()),
      way_(dynamics.particle_count()),
      applied_(dynamics.particle_count()) {
  Eigen::AlignedBox3d box;
  for (int i = 0; i < scene.dynamic_particles; ++i) box.extend(scene.initial_position[i]);
  size_ = box.isEmpty() ? 0 : box.diagonal().norm();
  if (dynamics.contact() != nullptr) dynamics.contact()->keep_matrix_definite();
}

bool EquilibriumNewton::evaluate(double time, std::span<const double> y) {
  fault_ = dynamics_.net_forces(time, y, force_);
  if (fault_) return false;
  for (std::size_t i = 0; i < residual_.size(); ++i) {
    residual_[i] = scene_.pinned[i] != 0 ? Vec3(Vec3::Zero()) : force_[i];
    if (!kept_.empty() && scene_.pinned[i] == 0) residual_[i] -= kept_[i];
  }
  return true;
}

bool EquilibriumNewton::factorise(double time, std::span<const double> y,
                                  Definiteness definiteness) {
  dynamics_.assemble(time, y, definiteness);
  const PhaseTimer timer(dynamics_.statistics().phases.linear_solve);
  ++factorisations_;
  const bool is_regular = factors_.factorise();
  if (definiteness == Definiteness::exact && is_regular) {
    negative_ = factors_.negative_directions();
    most_negative_ = std::max(most_negative_, negative_);
  }
  return is_regular;
}

bool EquilibriumNewton::is_converged(double time, std::span<const double> y, double move) {
  if (!(move <= scene_.source.time.position_tolerance)) return false;
  if (move <= correction_fraction * size_) return true;
  double left = 0, applied = 0;
  for (const Vec3& each : residual_) left += each.squaredNorm();
  for (std::size_t i = 0; i < force_.size(); ++i) {
    if (scene_.pinned[i] != 0) applied += force_[i].squaredNorm();
  }
  dynamics_.applied_loads(time, y, true, applied_);
  for (const Vec3& each : applied_) applied += each.squaredNorm();
  // Squares of enormous forces overflow.
  return std::isfinite(applied) && left <= residual_fraction * residual_fraction * applied;
}

int EquilibriumNewton::worst_particle() const {
  const auto worst =
      std::ranges::max_element(residual_, {}, [](const Vec3& each) { return each.squaredNorm(); });
  return static_cast<int>(worst - residual_.begin());
}

EquilibriumNewton::End EquilibriumNewton::solve(const Goal& goal, std::span<double> y,
                                                SafePath& path) {
  if (!evaluate(goal.time, y)) return End::blocked;
  const int most = goal.careful ? most_careful_iterations : most_iterations;
  double first_move = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most; ++i) {
    if (goal.should_stop && goal.should_stop()) return End::stopped;
    if (!find_way(goal, y)) return End::singular;
    double move = largest_length(way_);
    const double longest = size_ * (goal.careful ? longest_careful_correction : longest_correction);
    if (move > longest) {
      if (!goal.careful) return End::diverged;
      for (Vec3& each : way_) each *= longest / move;
      move = std::numeric_limits<double>::infinity();
    }
    const double taken = take_way(goal, y, path);
    if (taken == 0) return fault_ ? End::blocked : End::diverged;
    if (taken == 1 && is_converged(goal.time, y, move)) return End::converged;
    if (i == 0) first_move = move;
    if (!goal.careful && i >= trial_iterations && move > first_move) return End::diverged;
  }
  return End::diverged;
}

// Solves K way = residual; returns false if K is singular. A careful search replaces a K that has
// negative eigenvalues by the positive semi-definite matrix, if that is regular.
bool EquilibriumNewton::find_way(const Goal& goal, std::span<const double> y) {
  ++iterations_;
  if (!factorise(goal.time, y)) return false;
  if (goal.careful && negative_ > 0) {
    const bool is_definite =
        factorise(goal.time, y, Definiteness::semi_definite) && factors_.negative_directions() == 0;
    if (!is_definite && !factorise(goal.time, y)) return false;
  }
  const PhaseTimer timer(dynamics_.statistics().phases.linear_solve);
  return factors_.solve(residual_, way_);
}

// Moves `y` along the correction, halved until surfaces stay apart and the forces can be evaluated.
// If pull() is positive at the start, a careful search also shortens the correction until pull() at
// its end is at least -1/2 of that value. Returns the fraction taken. If no fraction is allowed,
// returns 0 and restores `y`.
double EquilibriumNewton::take_way(const Goal& goal, std::span<double> y, SafePath& path) {
  reached_.assign(y.begin(), y.end());
  const double start = pull();
  auto* const x = reinterpret_cast<Vec3*>(y.data());
  const StateView reached = StateView::of(reached_);
  for (double fraction = 1; fraction > shortest_fraction;) {
    for (std::size_t i = 0; i < way_.size(); ++i) x[i] = reached.position[i] + fraction * way_[i];
    const bool is_evaluated = evaluate(goal.time, y);
    const double now = is_evaluated ? pull() : 0;
    if (is_evaluated && goal.careful && start > 0 && now < -0.5 * start) {
      // The restoring force of a stretched membrane grows with the cube of the distance.
      fraction *= std::clamp(std::cbrt(start / (start - now)), 0.1, 0.8);
      continue;
    }
    if (is_evaluated) fault_ = path.move_to(goal.time, y);
    if (is_evaluated && !fault_) return fraction;
    fraction /= 2;
  }
  std::ranges::copy(reached_, y.begin());
  return 0;
}

// Returns the work (J) that the present residual would do along the whole correction.
double EquilibriumNewton::pull() const {
  double sum = 0;
  for (std::size_t i = 0; i < way_.size(); ++i) sum += way_[i].dot(residual_[i]);
  return sum;
}

}  // namespace weft::sim
