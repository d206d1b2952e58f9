// A limit of the principal stretches of a triangle: an energy that grows without bound towards it
// and vanishes, with its first two derivatives, below its onset.
//
// With the deformation gradient F (3 x 2) of the triangle, c_i the eigenvalues of F^T F (squares of
// the principal stretches), the largest stretch L = 1 + limit and its onset at c_0 = (1 + limit /
// 2)^2,
//   W = k sum_i b(d_i),   d_i = (L^2 - c_i) / (L^2 - c_0),   k = A E h (L^2 - c_0)^2 / 8,
//   b(d) = (1 - d)^3 / d for d < 1, else 0.
// The derivatives are b' = 3 - 2 d - 1 / d^2 and b'' = 2 / d^3 - 2. Below d = 0.02 the quadratic
// function with the same value and derivatives there stands for b, so that Newton's iterates may
// pass the limit; no accepted state does. b falls and is convex, hence W is convex in F, and in the
// positions of the nodes: its Hessian is positive semi-definite.
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

template <class Real>
struct StrainLimitOf {
  // Gradients of the linear functions that are 1 at node 1 or 2 and 0 at the others, along two
  // orthonormal axes of the rest plane, 1/m. That of node 0 is minus their sum.
  std::array<std::array<Real, 2>, 2> gradients{};
  Real onset = 1;      // c_0
  Real range = 1;      // L^2 - c_0
  Real stiffness = 0;  // k, J
};
using StrainLimit = StrainLimitOf<double>;

// Makes the limit of a triangle. `limit` > 0 is the largest principal strain, `stiffness` E h > 0
// (N/m); rest positions are columns (m). Precondition: the rest triangle has an area.
StrainLimit make_strain_limit(const Nodes3& rest, double limit, double stiffness);

// The squared principal stretches of a triangle, c_1 >= c_2, with what leads to them.
template <class Real>
struct PrincipalStretches {
  std::array<Vec3Of<Real>, 2> columns;  // of F
  std::array<Real, 2> squares;
  Real radius;         // (c_1 - c_2) / 2
  Real along, across;  // F^T F = mean 1 + radius [along across; across -along]
};

template <class Real>
PrincipalStretches<Real> principal_stretches(const StrainLimitOf<Real>& limit,
                                             const NodesOf<Real, 3>& x) {
  PrincipalStretches<Real> result;
  const Vec3Of<Real> one = x.col(1) - x.col(0), two = x.col(2) - x.col(0);
  for (int k = 0; k < 2; ++k)
    result.columns[k] = limit.gradients[0][k] * one + limit.gradients[1][k] * two;
  const Real first = squared_norm(result.columns[0]), last = squared_norm(result.columns[1]);
  const Real mean = 0.5 * (first + last), half = 0.5 * (first - last);
  const Real shear = dot(result.columns[0], result.columns[1]);
  const Real radius = square_root(half * half + shear * shear);
  result.radius = radius;
  result.squares = {mean + radius, mean - radius};
  const auto is_round = radius <= 0.0;
  const Real divisor = choose(is_round, 1.0, radius);
  result.along = choose(is_round, 1.0, half / divisor);
  result.across = choose(is_round, 0.0, shear / divisor);
  return result;
}

// Returns the larger squared stretch.
template <class Real>
Real largest_squared_stretch(const StrainLimitOf<Real>& limit, const NodesOf<Real, 3>& x) {
  return principal_stretches(limit, x).squares[0];
}
// Returns L^2, which largest_squared_stretch() of an accepted state stays below.
template <class Real>
Real limit_of_squared_stretch(const StrainLimitOf<Real>& limit) {
  return limit.onset + limit.range;
}

// b at d(c) and its derivatives by c.
template <class Real>
struct LimitTerm {
  Real value, slope, curvature;
};

template <class Real>
LimitTerm<Real> limit_term(const StrainLimitOf<Real>& limit, const Real& square) {
  constexpr double least = 0.02;
  const Real d = (limit.onset + limit.range - square) / limit.range;
  const Real inner = larger(d, least);
  const Real inverse = 1.0 / inner, beyond = d - inner;
  const Real rest = 1.0 - inner;
  const Real slope = 3.0 - 2.0 * inner - inverse * inverse;
  const Real curvature = 2.0 * inverse * inverse * inverse - 2.0;
  const auto is_slack = 1.0 <= d;
  const Real value = rest * rest * rest * inverse + beyond * (slope + 0.5 * curvature * beyond);
  return {choose(is_slack, 0.0, value),
          choose(is_slack, 0.0, -(slope + curvature * beyond) / limit.range),
          choose(is_slack, 0.0, curvature / (limit.range * limit.range))};
}

// Returns the energy, J.
template <class Real>
Real strain_limit_energy(const StrainLimitOf<Real>& limit, const NodesOf<Real, 3>& x) {
  const PrincipalStretches<Real> now = principal_stretches(limit, x);
  return limit.stiffness *
         (limit_term(limit, now.squares[0]).value + limit_term(limit, now.squares[1]).value);
}

// The derivatives of sum b by C = F^T F. With the projections P_1, P_2 on the principal directions,
// and M = q_1 q_2^T + q_2 q_1^T, the first is b_1' P_1 + b_2' P_2. The second is the form
//   b_1'' (P_1 : dC)^2 + b_2'' (P_2 : dC)^2 + (b_1' - b_2') / (c_1 - c_2) (M : dC)^2 / 2.
template <class Real>
struct LimitDerivatives {
  PrincipalStretches<Real> now;
  std::array<Real, 3> tension;  // xx, xy, yy of the first derivative
  std::array<Real, 3> factors;  // of the second derivative's three squares

  LimitDerivatives(const StrainLimitOf<Real>& limit, const NodesOf<Real, 3>& x)
      : now(principal_stretches(limit, x)) {
    const LimitTerm<Real> one = limit_term(limit, now.squares[0]);
    const LimitTerm<Real> two = limit_term(limit, now.squares[1]);
    const Real mean = 0.5 * (one.slope + two.slope), half = 0.5 * (one.slope - two.slope);
    tension = {mean + half * now.along, half * now.across, mean - half * now.along};
    // If both stretches are the same, the quotient tends to b''.
    const auto is_round = now.radius <= 1e-6 * limit.range;
    const Real quotient = choose(is_round, one.curvature, half / choose(is_round, 1.0, now.radius));
    factors = {one.curvature, two.curvature, 0.5 * quotient};
  }
  // The matrices P_1, P_2 and M as xx, xy, yy.
  std::array<Real, 3> direction(int square) const {
    if (square == 2) return {-now.across, now.along, now.across};
    const double sign = square == 0 ? 0.5 : -0.5;
    return {0.5 + sign * now.along, sign * now.across, 0.5 - sign * now.along};
  }
};

template <class Real>
std::array<Real, 2> limit_gradient(const StrainLimitOf<Real>& limit, int node) {
  if (node > 0) return limit.gradients[node - 1];
  return {-limit.gradients[0][0] - limit.gradients[1][0],
          -limit.gradients[0][1] - limit.gradients[1][1]};
}

// Returns S g for a symmetric S, given as xx, xy, yy.
template <class Real>
std::array<Real, 2> product(const std::array<Real, 3>& matrix, const std::array<Real, 2>& vector) {
  return {matrix[0] * vector[0] + matrix[1] * vector[1],
          matrix[1] * vector[0] + matrix[2] * vector[1]};
}

// Returns the forces on the three nodes as columns, N: -2 k F (dW/dC) g_a.
template <class Real>
NodesOf<Real, 3> strain_limit_forces(const StrainLimitOf<Real>& limit, const NodesOf<Real, 3>& x) {
  const LimitDerivatives<Real> derivatives(limit, x);
  const auto& columns = derivatives.now.columns;
  NodesOf<Real, 3> forces;
  for (int a = 1; a < 3; ++a) {
    const std::array<Real, 2> pull = product(derivatives.tension, limit_gradient(limit, a));
    forces.col(a) = -2.0 * limit.stiffness * (pull[0] * columns[0] + pull[1] * columns[1]);
  }
  forces.col(0) = -forces.col(1) - forces.col(2);
  return forces;
}

// Returns -d forces / d x, symmetric positive semi-definite, N/m.
template <class Real>
StencilMatrix<Real, 3> strain_limit_stiffness(const StrainLimitOf<Real>& limit,
                                              const NodesOf<Real, 3>& x) {
  const LimitDerivatives<Real> derivatives(limit, x);
  const auto& columns = derivatives.now.columns;
  std::array<std::array<Real, 2>, 3> gradients;
  for (int a = 0; a < 3; ++a) gradients[a] = limit_gradient(limit, a);
  StencilMatrix<Real, 3> result;
  for (int a = 0; a < 3; ++a) {
    const std::array<Real, 2> pull = product(derivatives.tension, gradients[a]);
    for (int b = a; b < 3; ++b) {
      const Real tension = 2.0 * (pull[0] * gradients[b][0] + pull[1] * gradients[b][1]);
      result(a, b) = tension * Mat3Of<Real>::Identity();
    }
  }
  for (int square = 0; square < 3; ++square) {
    const std::array<Real, 3> direction = derivatives.direction(square);
    Vec3Of<Real> slopes[3];  // d (direction : C) / d x
    for (int a = 0; a < 3; ++a) {
      const std::array<Real, 2> along = product(direction, gradients[a]);
      slopes[a] = 2.0 * (along[0] * columns[0] + along[1] * columns[1]);
    }
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b)
        result(a, b) += derivatives.factors[square] * outer<Real>(slopes[a], slopes[b]);
    }
  }
  result.scale(limit.stiffness);
  return result;
}

}  // namespace weft::materials
