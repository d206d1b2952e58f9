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

// The edge opposite each node, running round the triangle: x2 - x1, x0 - x2, x1 - x0, as columns.
inline Nodes3 opposite_edges(const Nodes3& x) {
  Nodes3 edges;
  edges.col(0) = x.col(2) - x.col(1);
  edges.col(1) = x.col(0) - x.col(2);
  edges.col(2) = x.col(1) - x.col(0);
  return edges;
}

// q, m^2.
inline Vec3 squared_length_changes(const TriangleMembrane& membrane, const Nodes3& edges) {
  const auto& rest = membrane.rest_squared_length;
  return {squared_norm(edges.col(0)) - rest[0], squared_norm(edges.col(1)) - rest[1],
          squared_norm(edges.col(2)) - rest[2]};
}

// J
inline double membrane_energy(const TriangleMembrane& membrane, const Nodes3& x) {
  const Vec3 change = squared_length_changes(membrane, opposite_edges(x));
  return 0.5 * dot(change, membrane.modulus * change);
}

// C (q + beta q'), one tension per edge, N/m: the edge i pulls its ends together with 2 s_i e_i.
inline Vec3 edge_tensions(const TriangleMembrane& membrane, const Nodes3& edges, const Nodes3& v) {
  Vec3 change = squared_length_changes(membrane, edges);
  if (membrane.damping_time != 0) {
    const double factor = 2 * membrane.damping_time;
    change[0] += factor * dot(edges.col(0), v.col(2) - v.col(1));
    change[1] += factor * dot(edges.col(1), v.col(0) - v.col(2));
    change[2] += factor * dot(edges.col(2), v.col(1) - v.col(0));
  }
  return membrane.modulus * change;
}

// Forces on the three nodes as columns, N. Inline: the hot loop of a cloth.
inline Nodes3 membrane_forces(const TriangleMembrane& membrane, const Nodes3& x, const Nodes3& v) {
  const Nodes3 edges = opposite_edges(x);
  const Vec3 tensions = edge_tensions(membrane, edges, v);
  const Vec3 pull0 = 2 * tensions[0] * edges.col(0);
  const Vec3 pull1 = 2 * tensions[1] * edges.col(1);
  const Vec3 pull2 = 2 * tensions[2] * edges.col(2);
  Nodes3 forces;
  forces.col(0) = pull2 - pull1;
  forces.col(1) = pull0 - pull2;
  forces.col(2) = pull1 - pull0;
  return forces;
}

// -d forces / d x with the stress of (x, v) (exact without damping), symmetric, N/m. Indefinite
// under compression; with `pull_only`, which leaves out the stress of edges that push, positive
// semi-definite.
Mat9 membrane_stiffness(const TriangleMembrane& membrane, const Nodes3& x, const Nodes3& v,
                        bool pull_only = false);
// -d forces / d v, exact, symmetric positive semi-definite, N s/m.
Mat9 membrane_damping(const TriangleMembrane& membrane, const Nodes3& x);

}  // namespace weft::materials
