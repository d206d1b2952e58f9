// One contact: two features, or a vertex and a term of a surface, with their forces and the slopes
// of these.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "bsi/detail/feature_batches.h"
#include "bsi/proximity.h"
#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// The law of contact (materials/contact.h) of one pair.
struct ContactLaw {
  double range = 0;           // m
  double stiffness = 0;       // N/m: of the barrier, for the pair's share of the area
  double damping_time = 0;    // s
  double friction = 0;        // Coulomb coefficient
  double friction_speed = 0;  // m/s
};

// Friction acts on the sliding velocity u, across the normal, and with the forces lever_i^T f where
// lever_i = du / dv_i. u is the velocity of the first side's closest point, less that of the second
// side's, both taken at one place: one side is carried on to the other as if it were rigid. Against
// an obstacle that is the obstacle, which is. Of two dynamic sides it is the second, by how its
// edges turn: then no rigid motion of all four points makes u, so that friction takes no power from
// one, and has neither a resultant nor a torque.
struct Sliding {
  std::array<Mat3, 4> lever;
  Vec3 force{0, 0, 0};        // N, on the first side
  Mat3 slope = Mat3::Zero();  // -d force / d u, N s/m: semi-definite across the normal, with the
                              // coefficient's sign
};

struct ContactPair {
  std::array<int, 4> nodes{};      // particles
  std::array<double, 4> weight{};  // of bsi::Closest: +1 in all on the first side, -1 on the second
  Vec3 normal{0, 0, 0};            // from the second side's closest point to the first's
  double coefficient = 1;          // how often the pair counts: negative where others overlap
  double gap = 0;                  // m
  double energy = 0;               // J
  double push = 0;                 // N along the normal, barrier and damping
  double stiffness = 0, damping = 0;  // of the push: -d/dgap, -d/drate
  int sliding = -1;                   // place of its friction in the list of these; -1: none
};

// Fills weights, normal, gap, energy, push and its slopes from a closest pair of points whose gap
// is positive; the barrier is multiplied by `mollifier`. `velocity`: of all particles, m/s. Returns
// the push of the barrier alone, N.
double apply_push(const ContactLaw& law, double thickness, double mollifier,
                  const bsi::Closest& closest, std::span<const Vec3> velocity, ContactPair& pair);

// The angular velocity (rad/s) of a triangle that moves as a rigid body; zero of one without area.
Vec3 rigid_spin(const std::array<Vec3, 3>& position, const std::array<Vec3, 3>& velocity);

// Friction of a pair whose push is known; nothing where there is none, or where the four points do
// not span a surface. `obstacle_spin`: angular velocity (rad/s) of the side that is an obstacle, if
// one is. `barrier_push`: what apply_push returned; with the damping in it, which leaps
// at an impact, Newton's iteration fails far more often.
std::optional<Sliding> friction_of(const ContactLaw& law, bsi::FeatureKind kind,
                                   double barrier_push, const bsi::Closest& closest,
                                   const bsi::FourPoints& points, std::span<const Vec3> velocity,
                                   const std::optional<Vec3>& obstacle_spin,
                                   const ContactPair& pair);

}  // namespace weft::sim
