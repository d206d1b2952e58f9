// Triangle springs (Delingette 2008): the St. Venant-Kirchhoff membrane in squared edge lengths,
// W = sum_i k_i/4 q_i^2 + sum_(i<j) c_ij/2 q_i q_j with q_i = l_i^2 - L_i^2, written W = 1/2 q^T C
// q. Kelvin-Voigt damping replaces q by q + beta q' in the force.
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

struct TriangleMembrane {
  std::array<double, 3> rest_squared_length{};  // of the edge opposite each node, m^2
  Mat3 modulus = Mat3::Zero();                  // C, N/m^3
  double damping_time = 0;                      // beta, s
};

// `stiffness` is E h (N/m), -1 < poisson_ratio < 1 (plane stress), rest positions as columns (m).
// Precondition: the rest triangle has an area.
TriangleMembrane make_triangle_membrane(const Nodes3& rest, double stiffness, double poisson_ratio,
                                        double damping_time);
double membrane_energy(const TriangleMembrane& membrane, const Nodes3& x);
// Forces on the three nodes as columns, N.
Nodes3 membrane_forces(const TriangleMembrane& membrane, const Nodes3& x, const Nodes3& v);
// -d forces / d x with the stress of (x, v) (exact without damping), symmetric, N/m.
Mat9 membrane_stiffness(const TriangleMembrane& membrane, const Nodes3& x, const Nodes3& v);
// -d forces / d v, exact, symmetric positive semi-definite, N s/m.
Mat9 membrane_damping(const TriangleMembrane& membrane, const Nodes3& x);

}  // namespace weft::materials
