// The angle between two triangles that share an edge, and its derivatives. Nodes: x0 -> x1 the
// shared edge, x2 and x3 the nodes across it: the triangles (x0, x1, x2) and (x1, x0, x3), both
// counter-clockwise seen from the same side.
#pragma once

#include <cmath>

#include "materials/types.h"

namespace weft::materials {

// What angle and gradient have in common; a caller who wants both makes it once. The edge, the arms
// from x0 to the nodes across it and the normals (m, m, m^2) of a hinge. `flat_triangle` is true
// when either triangle has no area (its sine at x0 is below 1e-12).
struct HingeVectors {
  Vec3 edge, arm2, arm3, normal2, normal3;
  double edge_length = 0, squared_normal2 = 0, squared_normal3 = 0;
  bool flat_triangle = false;
};
inline HingeVectors hinge_vectors(const Nodes4& x) {
  HingeVectors h;
  h.edge = x.col(1) - x.col(0);
  h.arm2 = x.col(2) - x.col(0);
  h.arm3 = x.col(3) - x.col(0);
  h.normal2 = h.edge.cross(h.arm2);
  h.normal3 = h.arm3.cross(h.edge);
  h.squared_normal2 = squared_norm(h.normal2);
  h.squared_normal3 = squared_norm(h.normal3);
  const double squared_edge = squared_norm(h.edge);
  h.edge_length = std::sqrt(squared_edge);
  const double smallest = 1e-24 * squared_edge;
  // Written so that NaN counts as a proper triangle and is handed on instead of hidden.
  h.flat_triangle = h.squared_normal2 <= smallest * squared_norm(h.arm2) ||
                    h.squared_normal3 <= smallest * squared_norm(h.arm3);
  return h;
}

// The angle is 0 when flat, in [-pi, pi], positive when the surface is a valley seen from that side
// (x3 above the plane of the first triangle). It jumps by 2 pi where the triangles fold onto each
// other. A triangle without area has no angle: 0, with no derivatives.
inline double hinge_angle(const HingeVectors& h) {
  if (h.flat_triangle) return 0;
  // sin ~ edge . (normal3 x normal2) / |edge| = |edge| arm3 . normal2, accurate near 0 and pi.
  return std::atan2(h.edge_length * dot(h.arm3, h.normal2), dot(h.normal2, h.normal3));
}
inline double hinge_angle(const Nodes4& x) { return hinge_angle(hinge_vectors(x)); }

// d angle / d x_i as columns, 1/m: a node across the edge lifts the angle by one over its height
// along the normal of its triangle, and the ends of the edge take the reactions of a lever.
inline Nodes4 hinge_gradient(const HingeVectors& h) {
  if (h.flat_triangle) return Nodes4::Zero();
  const Vec3 gradient2 = h.edge_length / h.squared_normal2 * h.normal2;
  const Vec3 gradient3 = h.edge_length / h.squared_normal3 * h.normal3;
  // Where along the edge the feet of the heights stand.
  const double inverse = 1 / (h.edge_length * h.edge_length);
  const double foot2 = dot(h.edge, h.arm2) * inverse;
  const double foot3 = dot(h.edge, h.arm3) * inverse;
  Nodes4 gradient;
  gradient.col(0) = (foot2 - 1) * gradient2 + (foot3 - 1) * gradient3;
  gradient.col(1) = -foot2 * gradient2 - foot3 * gradient3;
  gradient.col(2) = gradient2;
  gradient.col(3) = gradient3;
  return gradient;
}
inline Nodes4 hinge_gradient(const Nodes4& x) { return hinge_gradient(hinge_vectors(x)); }

// d^2 angle / dx dx, symmetric, 1/m^2. Each triangle gives its own part (as in Tamstorf and
// Grinspun 2013); the blocks that couple x2 and x3 are zero.
Mat12 hinge_hessian(const Nodes4& x);

}  // namespace weft::materials
