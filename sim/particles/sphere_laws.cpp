#include "sim/particles/sphere_laws.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

SphereLaws::SphereLaws(const Scene& scene)
    : scene_(scene), bodies_(static_cast<int>(scene.bodies.size())) {}

void SphereLaws::set_friction(double friction) {
  laws_.clear();
  for (int group = 0; group < scene_.dynamic_bodies; ++group) {
    const bool is_of_spheres = scene_.bodies[group].spheres != nullptr;
    for (int partner = 0; partner < bodies_; ++partner)
      laws_.push_back(is_of_spheres ? find(group, partner, friction) : SphereLaw{});
  }
}

SphereLaw SphereLaws::find(int group, int partner, double friction) const {
  const SceneBody &one = scene_.bodies[group], &other = scene_.bodies[partner];
  SphereLaw law{one.spheres->restitution, one.spheres->friction.value_or(friction)};
  if (other.spheres != nullptr) {
    law.restitution = std::max(law.restitution, other.spheres->restitution);
    law.friction = std::sqrt(law.friction * other.spheres->friction.value_or(friction));
  }
  const std::vector<std::string> names{one.name, other.name};
  for (const ContactPairCase& pair : scene_.source.contact.pair) {
    if (!std::ranges::is_permutation(pair.between, names)) continue;
    law.restitution = pair.restitution.value_or(law.restitution);
    law.friction = pair.friction.value_or(law.friction);
  }
  return law;
}

}  // namespace weft::sim
