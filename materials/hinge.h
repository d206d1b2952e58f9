// The angle between two triangles that share an edge, and its derivatives.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// Nodes: x0 -> x1 the shared edge, x2 and x3 the nodes across it: the triangles (x0, x1, x2) and
// (x1, x0, x3), both counter-clockwise seen from the same side. The angle is 0 when flat, in (-pi,
// pi), positive when the surface is a valley seen from that side (x3 above the plane of the first
// triangle).
double hinge_angle(const Nodes4& x);
// d angle / d x_i as columns, 1/m.
Nodes4 hinge_gradient(const Nodes4& x);
// d^2 angle / dx dx, symmetric, 1/m^2 (Tamstorf and Grinspun 2013).
Mat12 hinge_hessian(const Nodes4& x);

}  // namespace weft::materials
