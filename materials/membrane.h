// Triangle springs (Delingette 2008): the St. Venant-Kirchhoff membrane in squared edge lengths.
// With q_i = l_i^2 - L_i^2, the energy is
//   W = sum_i k_i/4 q_i^2 + sum_(i<j) c_ij/2 q_i q_j = 1/2 q^T C q.
// Kelvin-Voigt damping replaces q by q + beta q' in the force.
//
// The template parameter `Membrane` is TriangleMembraneOf, or a type with the same members and
// another C, such as OrthotropicMembraneOf (orthotropic_membrane.h).
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

template <class Real>
struct TriangleMembraneOf {
  std::array<Real, 3> rest_squared_length{};  // L_i^2 of the edge opposite node i, m^2
  // C = root root^T + shear (2 I - 1 1^T), N/m^3, where 1 is the vector of ones.
  Vec3Of<Real> root = Vec3Of<Real>::Zero();
  Real shear = 0;
  Real damping_time = 0;  // beta, s

  Real modulus(int i, int j) const { return root[i] * root[j] + (i == j ? shear : -shear); }
  Vec3Of<Real> times_modulus(const Vec3Of<Real>& q) const {
    const Real along = dot(root, q), sum = shear * (q[0] + q[1] + q[2]), twice = 2.0 * shear;
    return {along * root[0] + (twice * q[0] - sum), along * root[1] + (twice * q[1] - sum),
            along * root[2] + (twice * q[2] - sum)};
  }
};
using TriangleMembrane = TriangleMembraneOf<double>;

// Makes the membrane of a triangle. `rest` holds the positions of the nodes (m) as columns.
// `stiffness` is E h (N/m), `damping_time` is beta (s); -1 < poisson_ratio < 1 (plane stress).
// Precondition: the rest triangle has an area.
TriangleMembrane make_triangle_membrane(const Nodes3& rest, double stiffness, double poisson_ratio,
                                        double damping_time);

// Returns the edges of a triangle as columns. Column i is the edge opposite node i. Together they
// run round the triangle: x2 - x1, x0 - x2, x1 - x0.
template <class Real>
NodesOf<Real, 3> opposite_edges(const NodesOf<Real, 3>& x) {
  NodesOf<Real, 3> edges;
  edges.col(0) = x.col(2) - x.col(1);
  edges.col(1) = x.col(0) - x.col(2);
  edges.col(2) = x.col(1) - x.col(0);
  return edges;
}

template <class Real>
std::array<Real, 3> squared_lengths(const NodesOf<Real, 3>& edges) {
  return {squared_norm(edges.col(0)), squared_norm(edges.col(1)), squared_norm(edges.col(2))};
}

// Returns the changes q of the squared edge lengths, m^2.
template <class Real, class Membrane>
Vec3Of<Real> squared_length_changes(const Membrane& membrane, const NodesOf<Real, 3>& edges) {
  const auto& rest = membrane.rest_squared_length;
  const auto now = squared_lengths(edges);
  return {now[0] - rest[0], now[1] - rest[1], now[2] - rest[2]};
}

// Returns the rates q' of the squared edge lengths, m^2/s. The nodes have the velocities v (m/s).
template <class Real>
Vec3Of<Real> squared_length_rates(const NodesOf<Real, 3>& edges, const NodesOf<Real, 3>& v) {
  return {2.0 * dot(edges.col(0), v.col(2) - v.col(1)),
          2.0 * dot(edges.col(1), v.col(0) - v.col(2)),
          2.0 * dot(edges.col(2), v.col(1) - v.col(0))};
}

// Returns the energy W, J. x holds the positions of the nodes (m) as columns.
template <class Real, class Membrane>
Real membrane_energy(const Membrane& membrane, const NodesOf<Real, 3>& x) {
  const Vec3Of<Real> change = squared_length_changes(membrane, opposite_edges(x));
  return 0.5 * dot(change, membrane.times_modulus(change));
}

// Returns the tensions s = C (q + beta q'), one per edge, N/m. Edge i is the vector e_i. It pulls
// its ends together with the force 2 s_i e_i.
template <class Real, class Membrane>
Vec3Of<Real> edge_tensions(const Membrane& membrane, const NodesOf<Real, 3>& edges,
                           const NodesOf<Real, 3>& v) {
  const Vec3Of<Real> rates = squared_length_rates(edges, v);
  return membrane.times_modulus(squared_length_changes(membrane, edges) +
                                membrane.damping_time * rates);
}

// Returns the forces of the tensions on the three nodes as columns, N.
template <class Real>
NodesOf<Real, 3> pulls_of(const Vec3Of<Real>& tensions, const NodesOf<Real, 3>& edges) {
  const Vec3Of<Real> pull0 = 2.0 * tensions[0] * edges.col(0);
  const Vec3Of<Real> pull1 = 2.0 * tensions[1] * edges.col(1);
  const Vec3Of<Real> pull2 = 2.0 * tensions[2] * edges.col(2);
  NodesOf<Real, 3> forces;
  forces.col(0) = pull2 - pull1;
  forces.col(1) = pull0 - pull2;
  forces.col(2) = pull1 - pull0;
  return forces;
}

// Returns the forces on the three nodes as columns, N.
template <class Real, class Membrane>
NodesOf<Real, 3> membrane_forces(const Membrane& membrane, const NodesOf<Real, 3>& x,
                                 const NodesOf<Real, 3>& v) {
  const NodesOf<Real, 3> edges = opposite_edges(x);
  return pulls_of(edge_tensions(membrane, edges, v), edges);
}

// Returns the undamped forces of a quad's two triangles on its corners, N. The triangles have the
// nodes 0, 1, 2 and 1, 3, 2. Shared terms are computed once.
template <class Real, class Membrane>
NodesOf<Real, 4> undamped_membrane_forces(const Membrane& one, const Membrane& other,
                                          const NodesOf<Real, 4>& x) {
  const Vec3Of<Real> diagonal = x.col(2) - x.col(1);
  const Vec3Of<Real> to0 = x.col(0) - x.col(2), from0 = x.col(1) - x.col(0);
  const Vec3Of<Real> from3 = x.col(2) - x.col(3), to3 = x.col(3) - x.col(1);
  const Real length = squared_norm(diagonal);
  const auto &rest = one.rest_squared_length, &other_rest = other.rest_squared_length;
  const Vec3Of<Real> tensions = one.times_modulus(
      {length - rest[0], squared_norm(to0) - rest[1], squared_norm(from0) - rest[2]});
  const Vec3Of<Real> other_tensions =
      other.times_modulus({squared_norm(from3) - other_rest[0], length - other_rest[1],
                           squared_norm(to3) - other_rest[2]});
  const Vec3Of<Real> across = 2.0 * (tensions[0] + other_tensions[1]) * diagonal;
  const Vec3Of<Real> pull_to0 = 2.0 * tensions[1] * to0, pull_from0 = 2.0 * tensions[2] * from0;
  const Vec3Of<Real> pull_from3 = 2.0 * other_tensions[0] * from3;
  const Vec3Of<Real> pull_to3 = 2.0 * other_tensions[2] * to3;
  NodesOf<Real, 4> forces;
  forces.col(0) = pull_from0 - pull_to0;
  forces.col(1) = across - pull_from0 + pull_to3;
  forces.col(2) = pull_to0 - across - pull_from3;
  forces.col(3) = pull_from3 - pull_to3;
  return forces;
}

// Returns the material part of the stiffness, G C G^T with G = d q / d x, N/m. It is symmetric
// positive semi-definite. Multiplied by beta, it is exactly -d forces / d v, N s/m.
template <class Real, class Membrane>
StencilMatrix<Real, 3> membrane_material_stiffness(const Membrane& membrane,
                                                   const NodesOf<Real, 3>& x) {
  const NodesOf<Real, 3> edges = opposite_edges(x);
  // d q_i / d x is -2 e_i at node i + 1, 2 e_i at node i + 2 and 0 at node i, with node numbers
  // modulo 3. Node a therefore has 2 e_a1 from edge a1 and -2 e_a2 from edge a2.
  StencilMatrix<Real, 3> result;
  for (int a = 0; a < 3; ++a) {
    const int a1 = (a + 1) % 3, a2 = (a + 2) % 3;
    Vec3Of<Real> stress[3];  // 2 sum_i C_ij d q_i / d x_a, by j
    for (int j = 0; j < 3; ++j) {
      stress[j] = (4.0 * membrane.modulus(a1, j)) * edges.col(a1) -
                  (4.0 * membrane.modulus(a2, j)) * edges.col(a2);
    }
    for (int b = a; b < 3; ++b) {
      const int b1 = (b + 1) % 3, b2 = (b + 2) % 3;
      result(a, b) =
          outer<Real>(stress[b1], edges.col(b1)) - outer<Real>(stress[b2], edges.col(b2));
    }
  }
  return result;
}

// Returns the forces -G C G^T u (N) for a displacement u (m). The columns of u belong to the nodes.
template <class Real, class Membrane>
NodesOf<Real, 3> membrane_material_pulls(const Membrane& membrane, const NodesOf<Real, 3>& x,
                                         const NodesOf<Real, 3>& u) {
  const NodesOf<Real, 3> edges = opposite_edges(x);
  return pulls_of(membrane.times_modulus(squared_length_rates(edges, u)), edges);
}

// Adds the part of the stiffness (N/m) that stems from the tensions of edge_tensions(). The second
// derivative of q_i is 2 I in the diagonal blocks of both ends of edge i, and -2 I in the block
// between them. Edges under compression make this part indefinite. `pull_only` omits these edges,
// which makes the part positive semi-definite.
template <class Real>
void add_membrane_stress(const Vec3Of<Real>& tensions, bool pull_only,
                         StencilMatrix<Real, 3>& stiffness) {
  for (int i = 0; i < 3; ++i) {
    const int start = (i + 1) % 3, end = (i + 2) % 3;
    const Real twice = 2.0 * (pull_only ? larger(tensions[i], 0.0) : tensions[i]);
    stiffness(start, start).diagonal().array() += twice;
    stiffness(end, end).diagonal().array() += twice;
    stiffness(std::min(start, end), std::max(start, end)).diagonal().array() -= twice;
  }
}

// Returns the stiffness -d forces / d x at (x, v), symmetric, N/m. It is exact without damping and
// `pull_only`. With damping, the derivative of q' by x is omitted. `pull_only` omits the stress of
// edges under compression.
template <class Real, class Membrane>
StencilMatrix<Real, 3> membrane_stiffness(const Membrane& membrane, const NodesOf<Real, 3>& x,
                                          const NodesOf<Real, 3>& v, bool pull_only = false) {
  StencilMatrix<Real, 3> result = membrane_material_stiffness(membrane, x);
  add_membrane_stress(edge_tensions(membrane, opposite_edges(x), v), pull_only, result);
  return result;
}

}  // namespace weft::materials
