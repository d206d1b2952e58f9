// Loads that turn with a surface: pressure, forces fixed to its frame, and moments about an edge.
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

// The tangents of a surface x(u, v) at a point: a_u = dx/du and a_v = dx/dv, not parallel. The
// normal is n = a_u x a_v / |a_u x a_v|.
struct Tangents {
  Vec3 u{0, 0, 0}, v{0, 0, 0};
};

// Generalised forces of a load. In a displacement w(u, v) of the surface they do the virtual work
//   position . w + along_u . dw/du + along_v . dw/dv.
struct SurfaceForce {
  Vec3 position{0, 0, 0}, along_u{0, 0, 0}, along_v{0, 0, 0};
};

// Derivatives of `position`, `along_u` and `along_v`, in this order, by the tangents.
struct SurfaceForceSlopes {
  std::array<Mat3, 3> by_u, by_v;
};

// Returns the matrix [a] of the cross product: [a] b = a x b.
Mat3 cross_matrix(const Vec3& a);

// Returns the orthonormal frame of the surface with the columns e_1, e_2 and n: e_1 along a_u, e_2
// = n x e_1 in the tangent plane.
Mat3 frame_of(const Tangents& tangents);

// A pressure p (Pa) along the normal. The force per du dv is p a_u x a_v.
SurfaceForce pressure_load(const Tangents& tangents, double pressure);
SurfaceForceSlopes pressure_load_slopes(const Tangents& tangents, double pressure);

// A force f (N) that keeps its components c in the frame Q of the surface: f = Q c. A change of the
// tangents rotates the frame by dw, so that df = dw x f, with
//   dw = n (e_2 . da_u) / |a_u| - e_2 (n . da_u) / |a_u|
//        + e_1 (n . da_v - (a_v . e_1) (n . da_u) / |a_u|) / (a_v . e_2).
SurfaceForce turning_load(const Tangents& tangents, const Vec3& components);
SurfaceForceSlopes turning_load_slopes(const Tangents& tangents, const Vec3& components);

// A moment M (N m) about an edge along a_u, where the surface lies on the side of a_v. It does work
// on the rotation theta of the surface about the edge. A positive rotation would move a
// continuation of the surface beyond the edge along n. With nu, the outward unit normal of the edge
// in the tangent plane,
//   d theta = n . dx,nu = ((a_u . a_v) n . da_u / |a_u|^2 - n . da_v) |a_u| / |a_u x a_v|.
SurfaceForce edge_moment(const Tangents& tangents, double moment);
SurfaceForceSlopes edge_moment_slopes(const Tangents& tangents, double moment);

}  // namespace weft::materials
