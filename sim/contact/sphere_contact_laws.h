// Laws of contact between the spheres of [[particles]] and other bodies, under error control.
#pragma once

#include <vector>

#include "sim/contact/contact_pair.h"
#include "sim/particles/sphere_laws.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Spheres bounce off each other and off obstacles, with the restitution of the case. Points of
// cloth that hit a sphere do not bounce; the cloth as a whole rebounds by its elasticity. The
// barrier of a sphere stores the kinetic energy of an impact at the largest expected speed in about
// two thirds of its range, so that its stiffness follows from masses and not from an area. Spheres
// of less than a tenth of the heaviest one's mass have the barrier of that tenth.
class SphereContactLaws {
 public:
  // The scene must outlive the object. O(points).
  explicit SphereContactLaws(const Scene& scene);

  // Sets contact.friction, which holds for particles without a friction of their own.
  void set_friction(double friction) { laws_.set_friction(friction); }
  // Returns the law of a pair of two bodies, of which one at least is a group of spheres, whose
  // barrier has the `range` (m).
  ContactLaw of(int body_a, int body_b, double range) const;
  // Returns the Coulomb coefficient of two such bodies.
  double friction(int body_a, int body_b) const { return pair_law(body_a, body_b).friction; }
  // Returns the arms of the spheres that turn, of a pair of features of two bodies. They are chosen
  // so that friction has no torque on both bodies together: spheres share their distance in
  // proportion to their radii, and roll on the middle surface of cloth, which takes no torque. On
  // an obstacle, which takes any, a sphere has its radius as arm.
  std::array<SpinArm, 2> spins(int first, int second, const std::array<int, 4>& nodes,
                               const bsi::Closest& closest) const;

 private:
  const SphereLaw& pair_law(int body_a, int body_b) const;

  const Scene& scene_;
  SphereLaws laws_;
  double least_mass_ = 0;  // kg; barriers of lighter spheres are those of spheres of this mass
  // By body: the first surface point of its spins minus its own, or 0 if it does not turn.
  std::vector<int> to_spin_;
};

}  // namespace weft::sim
