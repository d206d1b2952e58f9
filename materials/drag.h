// Aerodynamic force on a triangle in a uniform wind.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// Air density times the coefficients, kg/m^3, not negative: force per area is
// 1/2 |w| (normal w_n + tangential w_t), w = wind - velocity of the centroid, split along the
// normal and the plane of the triangle. The force does not depend on which side is called the
// front, and its power on a body in still air is never positive.
struct Drag {
  double normal = 0;
  double tangential = 0;
};

// Total force on the triangle, N; each node gets a third. Zero for a triangle without area.
Vec3 drag_force(const Drag& drag, const Nodes3& x, const Nodes3& v, const Vec3& wind);
// -d force / d (centroid velocity), made symmetric positive semi-definite, N s/m: for the Newton
// matrix, a ninth in every block of a pair of nodes. With B = normal n n^T + tangential (I - n n^T)
// the force is A/2 |w| B w; the matrix is A/2 |w| (B + B w w^T B / w^T B w), exact along w always,
// and in every direction for a wind along the normal or in the plane. Zero in still air.
Mat3 drag_damping(const Drag& drag, const Nodes3& x, const Nodes3& v, const Vec3& wind);

}  // namespace weft::materials
