// Aerodynamic force on a piece of a surface, such as a triangle, in a uniform wind.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// Air density times the drag coefficients, kg/m^3, not negative. The force per area is 1/2 |w|
// (normal w_n + tangential w_t). w is the wind minus the velocity of the piece (of a triangle, of its
// centroid), split into parts along the normal and in its plane. The force does not depend on the orientation
// of the normal, and its power on a body in still air is never positive.
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
  Vec3Of<Real> normal;         // unit, or zero without area
  Real area;                   // m^2
};
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

// Returns B w of drag_damping(), kg/(m^2 s).
template <class Real>
Vec3Of<Real> weighted_wind(const DragOf<Real>& drag, const FlowOf<Real>& flow) {
  return drag.tangential * flow.relative_wind +
         ((drag.normal - drag.tangential) * dot(flow.relative_wind, flow.normal)) * flow.normal;
}

// Returns the total force, N.
template <class Real>
Vec3Of<Real> drag_force(const DragOf<Real>& drag, const FlowOf<Real>& flow) {
  return (0.5 * flow.area * square_root(squared_norm(flow.relative_wind))) *
         weighted_wind(drag, flow);
}
// Returns the total force on a triangle, N; each node receives a third. Zero for a triangle without
// area.
template <class Real>
Vec3Of<Real> drag_force(const DragOf<Real>& drag, const NodesOf<Real, 3>& x,
                        const NodesOf<Real, 3>& v, const Vec3Of<Real>& wind) {
  return drag_force(drag, flow_past(x, v, wind));
}

// Returns -d force / d velocity, made symmetric positive semi-definite for the Newton matrix, N s/m.
// With B = normal n n^T + tangential (I - n n^T), the force is A/2 |w| B w, and the matrix is A/2
// |w| (B + B w w^T B / w^T B w). It is exact along w; for a wind along the normal or in the plane it
// is exact in every direction. Zero in still air.
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
// The same of a triangle; every block of a pair of nodes receives a ninth.
template <class Real>
Mat3Of<Real> drag_damping(const DragOf<Real>& drag, const NodesOf<Real, 3>& x,
                          const NodesOf<Real, 3>& v, const Vec3Of<Real>& wind) {
  return drag_damping(drag, flow_past(x, v, wind));
}

}  // namespace weft::materials
