// Aerodynamic force on a piece of a surface, such as a triangle, in a uniform wind.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// The products of the air's density and the two drag coefficients, kg/m^3, not negative. The force
// per area is
//   1/2 |w| (normal w_n + tangential w_t).
// The relative wind w is the velocity of the wind minus the velocity of the piece. w_n is the part
// of w along the normal of the piece, w_t the part in its plane. The force does not depend on the
// sign of the normal. In still air, its power on the surface is never positive.
template <class Real>
struct DragOf {
  Real normal = 0;
  Real tangential = 0;
};
using Drag = DragOf<double>;

// The flow of air past a piece of a surface.
template <class Real>
struct FlowOf {
  Vec3Of<Real> relative_wind;  // w, m/s
  Vec3Of<Real> normal;         // unit normal of the piece, or zero if it has no area
  Real area;                   // m^2
};
// Returns the flow past a triangle that moves with the mean velocity of its nodes. The columns of x
// and v are the positions (m) and velocities (m/s) of the nodes. `wind` is in m/s.
template <class Real>
FlowOf<Real> flow_past(const NodesOf<Real, 3>& x, const NodesOf<Real, 3>& v,
                       const Vec3Of<Real>& wind) {
  FlowOf<Real> flow;
  flow.relative_wind = wind - (1.0 / 3) * (v.col(0) + v.col(1) + v.col(2));
  const Vec3Of<Real> side = x.col(1) - x.col(0), other = x.col(2) - x.col(0);
  const Vec3Of<Real> area = 0.5 * side.cross(other);
  flow.area = square_root(squared_norm(area));
  flow.normal = (1.0 / choose(flow.area == Real(0), 1.0, flow.area)) * area;
  return flow;
}

// Returns B w, kg/(m^2 s), with the matrix B = normal n n^T + tangential (I - n n^T).
template <class Real>
Vec3Of<Real> weighted_wind(const DragOf<Real>& drag, const FlowOf<Real>& flow) {
  return drag.tangential * flow.relative_wind +
         ((drag.normal - drag.tangential) * dot(flow.relative_wind, flow.normal)) * flow.normal;
}

// Returns the total force on the piece, N.
template <class Real>
Vec3Of<Real> drag_force(const DragOf<Real>& drag, const FlowOf<Real>& flow) {
  return (0.5 * flow.area * square_root(squared_norm(flow.relative_wind))) *
         weighted_wind(drag, flow);
}
// Returns the total force on a triangle (N), of which each node receives a third. The force on a
// triangle without area is zero.
template <class Real>
Vec3Of<Real> drag_force(const DragOf<Real>& drag, const NodesOf<Real, 3>& x,
                        const NodesOf<Real, 3>& v, const Vec3Of<Real>& wind) {
  return drag_force(drag, flow_past(x, v, wind));
}

// Returns an approximation of -d force / d velocity for the Newton matrix, symmetric positive
// semi-definite, N s/m. With B = normal n n^T + tangential (I - n n^T), the force is A/2 |w| B w.
// The returned matrix is
//   A/2 |w| (B + B w w^T B / w^T B w).
// Its product with w is exact. If w is along the normal or in the plane, the whole matrix is exact.
// It is zero for w = 0.
template <class Real>
Mat3Of<Real> drag_damping(const DragOf<Real>& drag, const FlowOf<Real>& flow) {
  const Vec3Of<Real> weighted = weighted_wind(drag, flow);
  const Real power = dot(weighted, flow.relative_wind);
  const auto is_still = power <= Real(0);
  const Real inverse_power = choose(is_still, 0.0, 1.0 / choose(is_still, 1.0, power));
  Mat3Of<Real> result = outer<Real>((drag.normal - drag.tangential) * flow.normal, flow.normal) +
                        outer<Real>(weighted, inverse_power * weighted);
  result.diagonal().array() += drag.tangential;
  return (0.5 * flow.area * square_root(squared_norm(flow.relative_wind))) * result;
}
// Returns the matrix of drag_damping() for a whole triangle, N s/m. The block of each pair of nodes
// receives a ninth of it.
template <class Real>
Mat3Of<Real> drag_damping(const DragOf<Real>& drag, const NodesOf<Real, 3>& x,
                          const NodesOf<Real, 3>& v, const Vec3Of<Real>& wind) {
  return drag_damping(drag, flow_past(x, v, wind));
}

}  // namespace weft::materials
