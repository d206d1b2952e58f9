// A pair of surface features in contact, with its forces and their derivatives. The features are a
// vertex and a triangle, or two edges.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "bsi/detail/feature_batches.h"
#include "bsi/proximity.h"
#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// Parameters of the contact law (materials/contact.h) for one pair.
struct ContactLaw {
  double range = 0;           // m
  double stiffness = 0;       // barrier stiffness times the area of the pair, N/m
  double damping_time = 0;    // s
  double friction = 0;        // Coulomb coefficient
  double friction_speed = 0;  // m/s
  // Friction speed by sticking distance of anchored contacts, 1/s.
  double hold_rate = 0;
  // Speed (m/s) below which a pair with a sphere settles, and the speed of parting over the speed
  // of approach (materials::bouncing_push). A settling_speed of zero: damping_time holds instead.
  double settling_speed = 0, restitution = 0;
};

// How the spin of a sphere adds to the sliding velocity of a pair (Sliding).
struct SpinArm {
  int point = -1;  // surface point that is the spin of the sphere; -1: the feature does not turn
  double arm = 0;
};

// Friction of a pair. It acts on the tangential sliding velocity u with the forces lever_i^T f,
// where lever_i = du / dv_i. u is the velocity of the first feature's closest point minus the
// velocity of the second feature there. To this end, one feature is extended as a rigid body. If a
// feature belongs to an obstacle, that feature is extended. Of two dynamic features, the second is
// extended. It rotates with its triangle or, for two edges, with the plane that both edges span. u
// is then zero in every rigid motion of all four points, so that the friction forces have neither a
// resultant nor a torque.
//
// A sphere that turns adds the velocity of its surface. With the normal n from the second feature
// to the first, a radius r and an angular velocity omega = w / r, that is n x w, whichever feature
// the sphere is. w is the velocity of the sphere's spin (sim/scene/sphere_groups.h), whose force is
// f x n. Both are multiplied by the `arm` of the sphere, the distance of its centre from the place
// where the friction acts, as part of r.
//
// For an anchored contact, ContactLaw::hold_rate times the displacement from the anchor is added to
// u. The displacement depends on the positions as u does on the velocities, so that its stiffness
// is the same rate times the derivative of the force.
//
// A correction by a given number assumes a force f(u) = force - slope (u - velocity), which need
// not be that of Coulomb's law at the velocities and pushes that it leads to (follow_step()).
struct Sliding {
  // The largest friction, N: the Coulomb coefficient times the push.
  struct Limit {
    double now = 0;
    double expected = 0;  // with obstacles, but no particles, at the end of the step ahead
    double per_gap = 0, per_rate = 0;  // slopes: -d/dgap (N/m), -d/drate (N s/m)
  };
  Limit limit;
  Vec3 velocity{0, 0, 0};  // u, m/s
  double hold_rate = 0;    // ContactLaw::hold_rate if the contact is anchored, else 0
  std::array<Mat3, 4> lever;
  std::array<SpinArm, 2> spins;  // of the first and the second feature
  Vec3 force{0, 0, 0};           // force on the first feature, N
  // -d force / d u, N s/m, or a secant in its place. Its sign is that of the coefficient.
  Mat3 slope = Mat3::Zero();
  // -d force / d displacement, N/m; zero without an anchor.
  Mat3 stiffness = Mat3::Zero();

  bool has_spins() const { return spins[0].point >= 0 || spins[1].point >= 0; }
};

struct ContactPair {
  std::array<int, 4> nodes{};  // surface points
  // Weights of the points, as in bsi::Closest. They sum to +1 on the first feature, and to -1 on
  // the second.
  std::array<double, 4> weight{};
  Vec3 normal{0, 0, 0};    // unit vector from the second feature to the first
  double coefficient = 1;  // factor of the pair's forces and energy; negative for subtracted terms
  double gap = 0;          // m
  double energy = 0;       // J
  double push = 0;         // force of barrier and damping along the normal, N
  double stiffness = 0, damping = 0;  // slopes of the push: -d/dgap (N/m), -d/drate (N s/m)
  int sliding = -1;                   // argument of SurfaceContact::sliding(); -1: no friction
  int surface = -1;  // body of the second feature if the first one is a sample, else -1
};

// Forces (N) from the slope of the mollifier on the four points of two nearly parallel edges.
struct MollifierForce {
  std::array<int, 4> nodes{};
  std::array<Vec3, 4> force;
};

// Sets the weights, normal, gap, energy, push and derivatives of the push in `pair` from its
// closest points. Preconditions: the gap is positive, and the nodes and the coefficient of `pair`
// are set. The barrier is multiplied by `mollifier`. `velocity` has the velocities of all surface
// points (m/s). Returns the push that limits friction, N: that of the barrier alone, or the whole
// push if the pair has a settling_speed.
double apply_push(const ContactLaw& law, double thickness, double mollifier,
                  const bsi::Closest& closest, std::span<const Vec3> velocity, ContactPair& pair);

// Returns the matrix M with M u = v x u.
Mat3 cross_matrix(const Vec3& v);

// Returns the angular velocity (rad/s) of a triangle that moves as a rigid body, or zero if it has
// no area.
Vec3 rigid_spin(const std::array<Vec3, 3>& position, const std::array<Vec3, 3>& velocity);

// The friction of a pair depends on these, beside its law and its push.
struct SlidingFeatures {
  bsi::FeatureKind kind;
  const bsi::Closest& closest;
  const bsi::FourPoints& points;   // m
  std::span<const Vec3> velocity;  // of all surface points, m/s
  // Angular velocity (rad/s) of the feature that belongs to an obstacle, if any. Zero for a sphere
  // and what it touches, which have their arms instead.
  std::optional<Vec3> obstacle_spin = {};
  std::array<SpinArm, 2> spins = {};
  const Vec3* from_anchor = nullptr;  // m, from the anchor to the first feature, if anchored
};

// The end of a linearised step.
struct SlidingEnd {
  Vec3 velocity;     // of sliding, m/s
  double limit = 0;  // N
  // Change of the speed of sliding (m/s) if the friction of all pairs becomes as large as its limit
  // and acts against this sliding.
  double slowing = 0;
};

// Makes the friction f(u) of a pair obey Coulomb's law at the end of a linearised step. If f
// exceeds the limit there, or if the limit would not end the sliding, the features slide on: f is
// the limit against the sliding velocity, and constant along it. Otherwise f is proportional to u,
// so that it at most ends the sliding. A term that `is_subtracted` has no slope. Returns the change
// of f at that end, N.
double follow_step(const SlidingEnd& end, const Vec3& normal, bool is_subtracted,
                   double friction_speed, Sliding& sliding);

// Returns the friction of a pair whose push is known. Returns nothing if there is no friction, or
// if two dynamic features do not span a surface. `barrier_push` is the result of apply_push(). It
// excludes the damping of cloth, which jumps at an impact and would make Newton's iteration fail
// more often.
std::optional<Sliding> friction_of(const ContactLaw& law, double barrier_push,
                                   const SlidingFeatures& features, const ContactPair& pair);

}  // namespace weft::sim
