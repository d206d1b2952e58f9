#include "sim/contact/sphere_contact_laws.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/scene/time_curve.h"

namespace weft::sim {

namespace {

// Least expected speed of impacts, m/s. It holds for particles at rest without gravity.
constexpr double least_impact_speed = 0.5;
// Speed below which a sphere settles, as a fraction of the expected speed of impacts. With less,
// spheres at rest are stiffer. With more, low bounces end earlier.
constexpr double settling_share = 2e-3;
// That fraction on cloth, whose light points would else change their velocity too abruptly.
constexpr double settling_share_on_cloth = 0.25;

// Returns the extent (m) of all particles at t = 0 along a unit vector.
double extent_along(const Scene& scene, const Vec3& direction) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& place : scene.initial_position) {
    low = std::min(low, direction.dot(place));
    high = std::max(high, direction.dot(place));
  }
  return high - low;
}

// Returns the largest speed (m/s) at the start, with that of a fall through the whole scene.
double impact_speed(const Scene& scene) {
  double speed = 0;
  for (const ParticlesCase& group : scene.source.particles)
    speed = std::max(speed, group.velocity.norm());
  const Vec3 gravity = TimeCurve<Vec3>(scene.source.world.gravity).at({});
  const double size = gravity.norm();
  const double height = size > 0 ? extent_along(scene, gravity / size) : 0;
  return std::max(least_impact_speed, std::sqrt(speed * speed + 2 * size * height));
}

}  // namespace

SphereContactLaws::SphereContactLaws(const Scene& scene)
    : scene_(scene), laws_(scene), impact_speed_(0), to_spin_(scene.bodies.size(), 0) {
  if (scene.source.particles.empty()) return;
  impact_speed_ = impact_speed(scene);
  set_friction(scene.source.contact.friction.constant_or_zero());
  for (const SceneBody& spins : scene.bodies) {
    if (!spins.are_spins) continue;
    const auto spheres = std::ranges::find(scene.bodies, spins.spheres, &SceneBody::spheres);
    to_spin_[spheres - scene.bodies.begin()] = spins.first_point - spheres->first_point;
  }
}

const SphereLaw& SphereContactLaws::pair_law(int body_a, int body_b) const {
  return scene_.bodies[body_a].spheres != nullptr ? laws_.of(body_a, body_b)
                                                  : laws_.of(body_b, body_a);
}

std::array<SpinArm, 2> SphereContactLaws::spins(int first, int second,
                                                const std::array<int, 4>& nodes,
                                                const bsi::Closest& closest) const {
  std::array<SpinArm, 2> result;
  for (const bool is_second : {false, true}) {
    const int body = is_second ? second : first, node = nodes[is_second ? 3 : 0];
    if (to_spin_[body] == 0) continue;
    const SceneBody& other = scene_.bodies[is_second ? first : second];
    const double radius = scene_.bodies[body].spheres->radius;
    const double distance = std::sqrt(closest.squared_distance);
    double arm = 1;
    if (other.spheres != nullptr) {
      arm = distance / (radius + other.spheres->radius);
    } else if (other.dynamic) {
      arm = distance / radius;
    }
    result[is_second ? 1 : 0] = {node + to_spin_[body], arm};
  }
  return result;
}

ContactLaw SphereContactLaws::of(int body_a, int body_b, double range) const {
  const SphereLaw& pair = pair_law(body_a, body_b);
  double inverse_mass = 0;
  bool has_cloth = false;
  for (const int b : {body_a, body_b}) {
    const SceneBody& body = scene_.bodies[b];
    if (body.spheres != nullptr) inverse_mass += 1 / scene_.mass[body.first_particle];
    has_cloth |= body.spheres == nullptr && body.dynamic;
  }
  const double relative_speed = impact_speed_ / range;
  ContactLaw law{.range = range,
                 .stiffness = relative_speed * relative_speed / inverse_mass,
                 .friction = pair.friction,
                 .friction_speed = scene_.source.contact.friction_speed};
  law.settling_speed = (has_cloth ? settling_share_on_cloth : settling_share) * impact_speed_;
  if (!has_cloth) law.restitution = pair.restitution;
  return law;
}

}  // namespace weft::sim
