#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bench/stability_cell.h"
#include "sim/accuracy/error_monitor.h"
#include "sim/case/case_text.h"
#include "sim/motion/tolerances.h"
#include "sim/view/crossings.h"

namespace weft::bench {

namespace {

using namespace sim;

constexpr double momentum_share = 1e-3;
constexpr double rest_share = 1e-3;  // of gravity
constexpr double hundred_tolerances = 100;

bool nothing_acts(const Scene& scene) {
  return !scene.source.contact.enabled && scene.source.world.gravity.is_zero() &&
         scene.prescribed.empty();
}

// True if only gravity and the material's own elasticity act, and nothing prescribed moves.
bool nothing_takes_energy(const Scene& scene) {
  const auto damps = [](const MaterialCase& m) {
    return !(m.mass_damping.is_zero() && m.membrane_damping_time().is_zero() &&
             m.bending_damping_time().is_zero() && m.normal_drag.is_zero() &&
             m.tangential_drag.is_zero());
  };
  for (int b = 0; b < scene.dynamic_bodies; ++b)
    if (damps(*scene.bodies[b].material)) return false;
  return !scene.source.contact.enabled && !something_is_moved(scene) &&
         !scene.source.world.gravity.varies();
}

std::string three_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

bool something_is_moved(const Scene& scene) {
  return std::any_of(scene.prescribed.begin(), scene.prescribed.end(),
                     [](const PrescribedMotion& motion) { return motion.moves; });
}

bool all_finite(std::span<const double> y) {
  return std::all_of(y.begin(), y.end(), [](double value) { return std::isfinite(value); });
}

bool is_clear(const std::string& failure) {
  const auto has = [&](const char* words) { return failure.find(words) != std::string::npos; };
  return (has("body \"") || has("obstacle \"")) && has(" at t = ");
}

Judge::Judge(const Scene& scene)
    : scene_(scene),
      dynamics_(scene, statistics_),
      mass_(std::accumulate(scene.mass.begin(), scene.mass.end(), 0.0)),
      keeps_momentum_(nothing_acts(scene)),
      keeps_energy_(nothing_takes_energy(scene)),
      start_(dynamics_.energies(0, dynamics_.initial_state())),
      start_momentum_(momentum(dynamics_.initial_state())),
      energy_watch_(dynamics_, dynamics_.initial_state()) {
  most_kinetic_ = start_.kinetic;
}

double Judge::energy_lost(double time, std::span<const double> y) {
  if (!keeps_energy_) return std::numeric_limits<double>::quiet_NaN();
  const Energies now = dynamics_.energies(time, y);
  const double most = std::max(most_kinetic_, now.kinetic);
  return most > 0 ? (start_.total() - now.total()) / most : 0;
}

std::string inexactness(const Scene& scene, Judge& judge, const ConvergedEnd* converged,
                        double tolerance, double time, std::span<const double> y,
                        CellResult& result) {
  result.lost = judge.energy_lost(time, y);
  if (converged != nullptr) {
    result.error = rms_distance(StateView::of(y).position, converged->position);
    const double moved = rms_distance(
        std::span(scene.initial_position).first(converged->position.size()), converged->position);
    const double allowed =
        strayed_share * moved + hundred_tolerances * tolerance + converged->agreement;
    if (!(result.error <= allowed))
      return three_digits(result.error) + " m from a converged run, which has moved by " +
             three_digits(moved) + " m";
  }
  if (result.lost > lost_share)
    return "has lost " + three_digits(100 * result.lost) + " % of the largest kinetic energy";
  return "";
}

std::optional<std::string> Judge::check(double time, std::span<const double> y) {
  const Energies now = dynamics_.energies(time, y);
  most_kinetic_ = std::max(most_kinetic_, now.kinetic);
  // The work of prescribed motion and wind needs every step; only the run's own watch sees them
  // all.
  if (!energy_watch_.external().is_possible()) {
    if (auto failure = energy_watch_.check(time, y, now)) return failure->text;
  }
  if (keeps_momentum_) return check_momentum(y);
  return scene_.source.contact.enabled ? check_surfaces(time, y) : std::nullopt;
}

std::optional<std::string> Judge::check_surfaces(double time, std::span<const double> y) {
  dynamics_.expand_all(time, y, position_, velocity_);
  std::vector<CrossingSurface> surfaces;
  for (const SceneBody& body : scene_.bodies) {
    surfaces.push_back(
        {std::span<const Vec3>(position_).subspan(body.first_particle, body.particle_count()),
         body.mesh.triangles, body.self_contact});
  }
  const std::string when = " at t = " + three_digits(time) + " s";
  if (const auto crossings = find_crossings(surfaces); !crossings.empty())
    return counted(std::ssize(crossings), "pair of triangles crosses", "pairs of triangles cross") +
           when;
  // In scenes in which nothing prescribed moves, the first surface is above the second.
  if (surfaces.size() < 2 || something_is_moved(scene_)) return std::nullopt;
  Vec3 centre = Vec3::Zero();
  for (const Vec3& x : surfaces[0].positions) centre += x;
  centre /= static_cast<double>(surfaces[0].positions.size());
  const auto& below = surfaces[1].positions;
  const auto nearest = std::min_element(below.begin(), below.end(), [&](auto& a, auto& b) {
    return (a - centre).template head<2>().squaredNorm() <
           (b - centre).template head<2>().squaredNorm();
  });
  if (nearest->z() <= centre.z()) return std::nullopt;
  return "\"" + scene_.bodies[0].name + "\" has come through \"" + scene_.bodies[1].name + "\"" +
         when;
}

Vec3 Judge::momentum(std::span<const double> y) const {
  const StateView state = StateView::of(y);
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < state.velocity.size(); ++i) sum += scene_.mass[i] * state.velocity[i];
  return sum;
}

std::optional<std::string> Judge::check_momentum(std::span<const double> y) const {
  const double change = (momentum(y) - start_momentum_).norm();
  const TimeCase& options = scene_.source.time;
  const double share = momentum_share + options.relative_tolerance;
  const double limit = std::sqrt(3.0) * mass_ * velocity_tolerance(options) +
                       share * std::sqrt(2 * mass_ * start_.kinetic);
  if (change <= limit) return std::nullopt;
  return "the momentum has changed by " + three_digits(change) + " N s of " +
         three_digits(start_momentum_.norm()) + " N s";
}

std::optional<std::string> Judge::check_rest(double time, std::span<const double> y) {
  std::vector<double> still(y.begin(), y.end()), rate(y.size());
  std::fill(still.begin() + static_cast<std::ptrdiff_t>(y.size() / 2), still.end(), 0.0);
  if (auto fault = dynamics_.rate(time, still, rate)) return fault->describe(scene_);
  const StateView left = StateView::of(rate);
  double sum = 0;
  for (std::size_t i = 0; i < left.velocity.size(); ++i)
    sum += scene_.mass[i] * left.velocity[i].squaredNorm();
  const double mean = std::sqrt(sum / mass_),
               gravity = scene_.source.world.gravity.constant().norm();
  if (mean <= rest_share * gravity) return std::nullopt;
  return "accelerations of " + three_digits(mean) + " m/s^2 are left at rest, of a gravity of " +
         three_digits(gravity);
}

}  // namespace weft::bench
