#include "sim/modes/left_out.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "sim/modes/mode_unknowns.h"
#include "sim/motion/dynamics.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

// Largest asymmetry of loads that have a potential. Finite differences make errors of 1e-9.
constexpr double largest_asymmetry = 1e-2;
// Number of pairs of random displacements.
constexpr int pairs = 4;
// Displacement of the finite differences, as a fraction of the size of the bodies.
constexpr double load_difference_part = 1e-6;

// Loads and their changes along displacements that pins and supports allow.
class LoadSlopes {
 public:
  LoadSlopes(Dynamics& dynamics, double time, std::span<const double> state)
      : dynamics_(dynamics), unknowns_(dynamics.scene()), time_(time), state_(state) {
    Eigen::AlignedBox3d box;
    for (const Vec3& each : StateView::of(state).position) box.extend(each);
    step_ = load_difference_part * box.diagonal().norm();
  }

  ModeUnknowns::Vector random_displacement() {
    ModeUnknowns::Vector values(unknowns_.count());
    for (double& each : values) each = static_cast<double>(random_()) / 0x1p31 - 1;
    return values;
  }
  // Returns the change of the loads (N) per length of a displacement.
  ModeUnknowns::Vector slope(const ModeUnknowns::Vector& displacement) {
    std::vector<Vec3> way(dynamics_.particle_count());
    unknowns_.scatter(displacement, way);
    return (loads_at(way, step_) - loads_at(way, -step_)) / (2 * step_);
  }

 private:
  ModeUnknowns::Vector loads_at(std::span<const Vec3> way, double step) {
    std::vector<double> y(state_.begin(), state_.end());
    auto* const x = reinterpret_cast<Vec3*>(y.data());
    for (std::size_t i = 0; i < way.size(); ++i) x[i] += step * way[i];
    std::vector<Vec3> load(way.size());
    dynamics_.applied_loads(time_, y, false, load);
    return unknowns_.gather(load);
  }

  Dynamics& dynamics_;
  ModeUnknowns unknowns_;
  double time_;  // s
  std::span<const double> state_;
  double step_ = 0;  // m
  std::mt19937 random_;
};

// True if a force turns with the surface. Pressures are not judged: on a surface whose border is
// held they have a potential, up to errors of the quadrature on splines.
bool turns(const LoadCase& load) { return load.follower; }

bool has_drag(const SceneBody& body) {
  return !body.material->normal_drag.is_zero() || !body.material->tangential_drag.is_zero();
}

}  // namespace

double load_asymmetry(Dynamics& dynamics, double time, std::span<const double> state) {
  LoadSlopes loads(dynamics, time, state);
  double difference = 0, all = 0;
  for (int i = 0; i < pairs; ++i) {
    const ModeUnknowns::Vector a = loads.random_displacement(), b = loads.random_displacement();
    const double one = a.dot(loads.slope(b)), other = b.dot(loads.slope(a));
    difference += (one - other) * (one - other);
    all += (one * one + other * other) / 2;
  }
  return all > 0 ? std::sqrt(difference / all) : 0;
}

std::vector<std::string> left_out_forces(Dynamics& dynamics, double time,
                                         std::span<const double> state) {
  std::vector<std::string> warnings;
  const Scene& scene = dynamics.scene();
  if (std::ranges::any_of(scene.source.load, turns) &&
      load_asymmetry(dynamics, time, state) > largest_asymmetry)
    warnings.emplace_back(
        "the loads that turn with the surface have no potential: only the symmetric part of their "
        "stiffness is taken, which may miss the load at which the motion grows");
  const std::span<const SceneBody> bodies(scene.bodies);
  if (!scene.source.world.wind.is_zero() &&
      std::ranges::any_of(bodies.first(scene.dynamic_bodies), has_drag))
    warnings.emplace_back(
        "the wind acts on bodies with drag: how its forces change with their shape and motion is "
        "left out");
  return warnings;
}

}  // namespace weft::sim
