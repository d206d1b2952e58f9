// The angle between two triangles that share an edge (a hinge), and its derivatives. The shared
// edge runs from node x0 to node x1; x2 and x3 are the opposite nodes. The triangles (x0, x1, x2)
// and (x1, x0, x3) are counter-clockwise as seen from the side to which their normals point.
#pragma once

#include "materials/membrane.h"
#include "materials/types.h"

namespace weft::materials {

// The vectors from which the angle of a hinge and its gradient are computed: the edge (m), the arms
// from x0 to the opposite nodes (m) and the normals of the triangles (m^2). `flat_triangle` is true
// if a triangle has no area: the sine of its angle at x0 is at most 1e-12.
template <class Real>
struct HingeVectorsOf {
  Vec3Of<Real> edge, arm2, arm3, normal2, normal3;
  Real edge_length, squared_normal2, squared_normal3;
  decltype(Real() < Real()) flat_triangle;
};
using HingeVectors = HingeVectorsOf<double>;

// Returns true if a triangle with this squared normal and these two squared sides has no area. NaN
// gives false, which lets NaN propagate instead of being taken for a flat triangle.
template <class Real>
auto is_flat(const Real& squared_normal, const Real& squared_side, const Real& squared_other) {
  return squared_normal <= 1e-24 * squared_side * squared_other;
}

template <class Real>
HingeVectorsOf<Real> hinge_vectors(const NodesOf<Real, 4>& x) {
  HingeVectorsOf<Real> h;
  h.edge = x.col(1) - x.col(0);
  h.arm2 = x.col(2) - x.col(0);
  h.arm3 = x.col(3) - x.col(0);
  h.normal2 = h.edge.cross(h.arm2);
  h.normal3 = h.arm3.cross(h.edge);
  h.squared_normal2 = squared_norm(h.normal2);
  h.squared_normal3 = squared_norm(h.normal3);
  const Real squared_edge = squared_norm(h.edge);
  h.edge_length = square_root(squared_edge);
  h.flat_triangle = is_flat<Real>(h.squared_normal2, squared_edge, squared_norm(h.arm2)) |
                    is_flat<Real>(h.squared_normal3, squared_edge, squared_norm(h.arm3));
  return h;
}

// Returns the angle of a hinge in [-pi, pi]. It is 0 if the hinge is flat. It is positive if x3
// lies above the plane of the first triangle: seen from the side of the normals, the surface is a
// valley. It jumps by 2 pi where the triangles fold onto each other. If a triangle has no area, the
// result is 0.
template <class Real>
Real hinge_angle(const HingeVectorsOf<Real>& h) {
  // The sine is proportional to edge . (normal3 x normal2) / |edge|, which equals |edge| arm3 .
  // normal2. The second form is accurate near 0 and pi.
  return choose(h.flat_triangle, 0.0,
                arc_tangent(h.edge_length * dot(h.arm3, h.normal2), dot(h.normal2, h.normal3)));
}
inline double hinge_angle(const Nodes4& x) { return hinge_angle(hinge_vectors(x)); }

// Returns d angle / d x_i as columns, 1/m. If a triangle has no area, all derivatives are zero. The
// gradient at an opposite node lies along the normal of its triangle, with the length 1 / height of
// the node. The gradients at the ends of the edge balance these two in force and moment.
template <class Real>
NodesOf<Real, 4> hinge_gradient(const HingeVectorsOf<Real>& h) {
  const auto over = [&](const Real& numerator, const Real& denominator) {
    return choose(h.flat_triangle, 0.0, numerator / choose(h.flat_triangle, 1.0, denominator));
  };
  const Vec3Of<Real> gradient2 = over(h.edge_length, h.squared_normal2) * h.normal2;
  const Vec3Of<Real> gradient3 = over(h.edge_length, h.squared_normal3) * h.normal3;
  // Feet of the two heights, as fractions of the edge from x0.
  const Real inverse = over(1.0, h.edge_length * h.edge_length);
  const Real foot2 = dot(h.edge, h.arm2) * inverse;
  const Real foot3 = dot(h.edge, h.arm3) * inverse;
  NodesOf<Real, 4> gradient;
  gradient.col(0) = (foot2 - 1.0) * gradient2 + (foot3 - 1.0) * gradient3;
  gradient.col(1) = -foot2 * gradient2 - foot3 * gradient3;
  gradient.col(2) = gradient2;
  gradient.col(3) = gradient3;
  return gradient;
}
inline Nodes4 hinge_gradient(const Nodes4& x) { return hinge_gradient(hinge_vectors(x)); }

// The contribution of one triangle to sum_i moment_i d^2 angle_i / dx dx, where hinge i has the
// edge opposite node i of the triangle. The second derivative of the angle of a hinge is the sum of
// the contributions of its two triangles. A contribution is symmetric and involves only the nodes
// of its triangle, since x2 and x3 of a hinge are not coupled (Tamstorf and Grinspun 2013, Discrete
// bending forces and their Jacobians). Its unit is that of the moments / m^2. A triangle without
// area contributes zero.
//
// Derivation, for the edge from p to q of a triangle (p, q, r). N is the unit normal, e the unit
// edge, and l the length of the edge. m is the unit vector in the plane, normal to the edge and
// towards r. h is the height of r. t is the foot of this height, as a fraction of the edge from p.
// With w = (t - 1, -t, 1) and s = (-1, 1, 0), the gradient at node a is w_a N / h. Its derivative
// follows from
//   dN = -(m/h) N.D - (e/l) N.d(q - p),  dh = m.D,
//   dt = e.D / l + h/l^2 m.d(q - p),  D = sum_b w_b dx_b.
// Block (a, b) is therefore
//   -w_a w_b/h^2 (m N^T + N m^T) - (s_a w_b N e^T + w_a s_b e N^T)/(h l) - s_a s_b/l^2 N m^T.
// The last term is not symmetric, but its sum over both triangles is. Each triangle therefore
// contributes only the symmetric part of this term. All terms contain N: block (a, b) is
// N c_ab^T + c_ba N^T.
template <class Real>
class HingeStress {
 public:
  // Starts the sum with the hinge opposite node i. `x` holds the positions of the nodes (m) as
  // columns. add() adds another hinge.
  HingeStress(const NodesOf<Real, 3>& x, int i, const Real& moment) : edges_(opposite_edges(x)) {
    const Vec3Of<Real> first = edges_.col(0), second = edges_.col(1);
    const Vec3Of<Real> normal = first.cross(second);
    const Real squared_normal = squared_norm(normal);
    flat_ = is_flat<Real>(squared_normal, squared_norm(first), squared_norm(second));
    inverse_area_ = 1.0 / choose(flat_, 1.0, square_root(squared_normal));
    normal_ = choose(flat_, 0.0, inverse_area_) * normal;
    add_stress<true>(i, moment);
  }
  void add(int i, const Real& moment) { add_stress<false>(i, moment); }

  // Returns the block of the contribution for nodes a and b, with the derivatives by x_a and x_b.
  Mat3Of<Real> block(int a, int b) const {
    return outer<Real>(normal_, c_[a][b]) + outer<Real>(c_[b][a], normal_);
  }

 private:
  template <bool is_first>
  void add_stress(int i, const Real& moment) {
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    const Vec3Of<Real> edge = edges_.col(i);
    const Real inverse_length = 1.0 / choose(flat_, 1.0, square_root(squared_norm(edge)));
    const Vec3Of<Real> unit_edge = inverse_length * edge;
    const Vec3Of<Real> inward = normal_.cross(unit_edge);
    const Real inverse_height = inverse_area_ / inverse_length;
    const Real foot = -dot(edge, edges_.col(q)) * inverse_length * inverse_length;
    const Vec3Of<Real> pull = -moment * inverse_height * inverse_height * inward;
    const Vec3Of<Real> rotation = -0.5 * moment * inverse_length * inverse_length * inward;
    const Vec3Of<Real> slide = -moment * inverse_height * inverse_length * unit_edge;
    Real w[3];
    w[p] = foot - 1.0, w[q] = -foot, w[i] = 1.0;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        Vec3Of<Real> term = w[a] * w[b] * pull;
        if (a == p) term -= w[b] * slide;
        if (a == q) term += w[b] * slide;
        if (a != i && b != i && a == b) term += rotation;
        if (a != i && b != i && a != b) term -= rotation;
        if constexpr (is_first) {
          c_[a][b] = term;
        } else {
          c_[a][b] += term;
        }
      }
    }
  }

  NodesOf<Real, 3> edges_;
  Vec3Of<Real> normal_, c_[3][3];
  Real inverse_area_;  // 1 / (2 area), 1/m^2
  decltype(Real() < Real()) flat_;
};

}  // namespace weft::materials
