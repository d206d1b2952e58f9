// A spring between two nodes with Kelvin-Voigt damping. At the length l, it has the energy
// W = k (l - L)^2 / 2 and the Rayleigh dissipation function k beta l'^2 / 2.
#pragma once

#include <algorithm>
#include <cmath>

#include "materials/types.h"

namespace weft::materials {

struct Spring {
  double rest_length = 0;   // L, m
  double stiffness = 0;     // k, N/m
  double damping_time = 0;  // beta, s
};

// Returns the energy, J, at the positions x0 and x1 of the nodes (m).
inline double spring_energy(const Spring& spring, const Vec3& x0, const Vec3& x1) {
  const double extension = (x1 - x0).norm() - spring.rest_length;
  return 0.5 * spring.stiffness * extension * extension;
}

// Returns the force on node 0, N. The force on node 1 is its opposite. Coincident nodes have no
// force.
inline Vec3 spring_force(const Spring& spring, const Vec3& x0, const Vec3& x1, const Vec3& v0,
                         const Vec3& v1) {
  const Vec3 difference = x1 - x0;
  const double squared_length = squared_norm(difference);
  if (squared_length == 0) return Vec3::Zero();
  const double length = std::sqrt(squared_length);
  // The force is a multiple of d = x1 - x0, so the rate l' enters as l' / l = d . d' / l^2.
  const double rate_over_length = dot(difference, v1 - v0) / squared_length;
  return (spring.stiffness *
          (1 - spring.rest_length / length + spring.damping_time * rate_over_length)) *
         difference;
}

// Returns K = -d force0 / d x0 (N/m), exact without damping and `pull_only`. With damping, the
// derivative of l' is omitted. The stiffness matrix of both nodes is [K -K; -K K]. With the
// spring's tension T and unit vector n,
//   K = k n n^T + T/l (I - n n^T).
// K is indefinite under compression. `pull_only` clamps T/l to [0, k], which makes K positive
// semi-definite. For coincident nodes K is k I: exact for a spring without rest length, and usable
// for a Newton step otherwise.
inline Mat3 spring_stiffness(const Spring& spring, const Vec3& x0, const Vec3& x1, const Vec3& v0,
                             const Vec3& v1, bool pull_only = false) {
  const Vec3 difference = x1 - x0;
  const double squared_length = squared_norm(difference);
  if (squared_length == 0) return spring.stiffness * Mat3::Identity();
  const double length = std::sqrt(squared_length);
  const double rate_over_length = dot(difference, v1 - v0) / squared_length;
  double tension_over_length =
      spring.stiffness * (1 - spring.rest_length / length + spring.damping_time * rate_over_length);
  // T/l is at most k, because the first term below has the factor k - T/l.
  if (pull_only) tension_over_length = std::clamp(tension_over_length, 0.0, spring.stiffness);
  Mat3 result = ((spring.stiffness - tension_over_length) / squared_length * difference) *
                difference.transpose();
  result.diagonal().array() += tension_over_length;
  return result;
}

// Returns -d force0 / d v0, N s/m: exact and positive semi-definite. It is zero for coincident
// nodes.
inline Mat3 spring_damping(const Spring& spring, const Vec3& x0, const Vec3& x1) {
  const Vec3 difference = x1 - x0;
  const double squared_length = squared_norm(difference);
  if (squared_length == 0) return Mat3::Zero();
  return (spring.stiffness * spring.damping_time / squared_length * difference) *
         difference.transpose();
}

}  // namespace weft::materials
