#include "sim/contact/sphere_contact_laws.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

namespace {

// Speed below which a sphere settles, as a fraction of the expected speed of impacts. With less,
// spheres at rest are stiffer. With more, low bounces end earlier.
constexpr double settling_share = 2e-3;
// That fraction on cloth, whose light points would else change their velocity too abruptly.
constexpr double settling_share_on_cloth = 0.25;
// Smallest mass from which the strength of a barrier follows, as a share of the mass of the
// heaviest sphere of the scene. Without it, the barrier of a light sphere would not carry the
// impact of one that is a hundred times as heavy.
constexpr double share_of_heaviest = 0.1;
// Number of the shortest steps of the method in which the fastest impact passes from approach to
// parting. Else no step would be short enough for it.
constexpr double reversal_steps = 20;

}  // namespace

SphereContactLaws::SphereContactLaws(const Scene& scene)
    : scene_(scene), laws_(scene), to_spin_(scene.bodies.size(), 0) {
  if (scene.source.particles.empty()) return;
  set_friction(scene.source.contact.friction.constant_or_zero());
  for (const SceneBody& body : scene.bodies) {
    if (body.spheres != nullptr)
      least_mass_ = std::max(least_mass_, share_of_heaviest * scene.mass[body.first_particle]);
  }
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
    if (body.spheres != nullptr)
      inverse_mass += 1 / std::max(scene_.mass[body.first_particle], least_mass_);
    has_cloth |= body.spheres == nullptr && body.dynamic;
  }
  const double speed = scene_.impact_speed, relative_speed = speed / range;
  ContactLaw law{.range = range,
                 .stiffness = relative_speed * relative_speed / inverse_mass,
                 .friction = pair.friction,
                 .friction_speed = scene_.source.contact.friction_speed};
  const double reversal = reversal_steps * scene_.source.time.minimum_step;
  law.settling_speed = std::max((has_cloth ? settling_share_on_cloth : settling_share) * speed,
                                0.5 * reversal * relative_speed * speed);
  if (!has_cloth) law.restitution = pair.restitution;
  return law;
}

}  // namespace weft::sim
