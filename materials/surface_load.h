// Loads that rotate with a surface: pressure, forces with constant components in the surface's
// frame, and moments about an edge. The functions *_slopes() return the derivatives of a load by
// the tangents of the surface.
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

// The tangents of a surface x(u, v) at a point: a_u = dx/du and a_v = dx/dv, not parallel. The
// normal is n = a_u x a_v / |a_u x a_v|.
struct Tangents {
  Vec3 u{0, 0, 0}, v{0, 0, 0};
};

// Generalised forces of a load. For a displacement w(u, v) of the surface, their virtual work is
//   position . w + along_u . dw/du + along_v . dw/dv.
struct SurfaceForce {
  Vec3 position{0, 0, 0}, along_u{0, 0, 0}, along_v{0, 0, 0};
};

// Derivatives of a SurfaceForce by the tangents a_u and a_v. The three matrices belong to
// `position`, `along_u` and `along_v`.
struct SurfaceForceSlopes {
  std::array<Mat3, 3> by_u, by_v;
};

// Returns the matrix [a] of the cross product: [a] b = a x b.
Mat3 cross_matrix(const Vec3& a);

// Returns the orthonormal frame of the surface. Its columns are e_1 along a_u, e_2 = n x e_1 in the
// tangent plane, and n.
Mat3 frame_of(const Tangents& tangents);

// The load of a pressure p (Pa) in the direction of the normal. Its force per du dv is
// p a_u x a_v (N).
SurfaceForce pressure_load(const Tangents& tangents, double pressure);
SurfaceForceSlopes pressure_load_slopes(const Tangents& tangents, double pressure);

// The load of a force f (N) with constant components c in the frame Q = frame_of(tangents): f = Q
// c. A change of the tangents rotates the frame by dw, and df = dw x f, with
//   dw = n (e_2 . da_u) / |a_u| - e_2 (n . da_u) / |a_u|
//        + e_1 (n . da_v - (a_v . e_1) (n . da_u) / |a_u|) / (a_v . e_2).
SurfaceForce turning_load(const Tangents& tangents, const Vec3& components);
SurfaceForceSlopes turning_load_slopes(const Tangents& tangents, const Vec3& components);

// The load of a moment M (N m) about an edge. The edge runs along a_u, and the surface is on the
// side of a_v. The moment does work on the rotation theta of the surface about the edge. theta is
// positive if the rotation would move points beyond the edge in the direction n. With nu, the
// outward unit normal of the edge in the tangent plane,
//   d theta = n . dx,nu = ((a_u . a_v) n . da_u / |a_u|^2 - n . da_v) |a_u| / |a_u x a_v|.
SurfaceForce edge_moment(const Tangents& tangents, double moment);
SurfaceForceSlopes edge_moment_slopes(const Tangents& tangents, double moment);

}  // namespace weft::materials
