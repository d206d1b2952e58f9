// Restitution and friction between groups of spheres, and between spheres and obstacles.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

struct SphereLaw {
  double restitution = 0;  // speed of parting after an impact, divided by the speed of approach
  double friction = 0;     // Coulomb coefficient
};

// The laws of all pairs of a group of spheres and a partner: another group, the same group, cloth
// or an obstacle. A [[contact.pair]] precedes the keys of the particles. Against cloth and
// obstacles the keys of the particles hold. Between two groups the larger restitution holds, and
// the geometric mean of the frictions.
class SphereLaws {
 public:
  // The scene must outlive the object.
  explicit SphereLaws(const Scene& scene);

  // Sets contact.friction, which holds for particles without a friction of their own.
  void set_friction(double friction);
  // `group` is the index of a group in Scene::bodies, and so is `partner` of a group, cloth or an
  // obstacle.
  const SphereLaw& of(int group, int partner) const { return laws_[group * bodies_ + partner]; }

 private:
  SphereLaw find(int group, int partner, double friction) const;

  const Scene& scene_;
  int bodies_;
  std::vector<SphereLaw> laws_;
};

}  // namespace weft::sim
