// Aerodynamic force on a triangle in a uniform wind.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// Air density times the coefficients, kg/m^3: force per area is
// rho/2 (normal * |w| w_n + tangential * |w| w_t), w = wind - velocity of the centroid, split along
// the normal and the plane of the triangle.
struct Drag {
  double normal = 0;
  double tangential = 0;
};

// Total force on the triangle, N; each node gets a third.
Vec3 drag_force(const Drag& drag, const Nodes3& x, const Nodes3& v, const Vec3& wind);
// -d force / d (centroid velocity), made symmetric positive semi-definite, N s/m: for the Newton
// matrix.
Mat3 drag_damping(const Drag& drag, const Nodes3& x, const Nodes3& v, const Vec3& wind);

}  // namespace weft::materials
