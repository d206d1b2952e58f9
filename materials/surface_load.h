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

// Generalised forces of a load: the virtual work of a displacement w(u, v) of the surface is
//   position . w + along_u . dw/du + along_v . dw/dv.
struct SurfaceForce {
  Vec3 position{0, 0, 0}, along_u{0, 0, 0}, along_v{0, 0, 0};
};

// Derivatives of `position`, `along_u` and `along_v`, in this order, by the tangents.
struct SurfaceForceSlopes {
  std::array<Mat3, 3> by_u, by_v;
};

// The matrix [a] of the cross product: [a] b = a x b.
Mat3 cross_matrix(const Vec3& a);

// Orthonormal frame of the surface, as columns: along a_u, in the plane beside it, along n.
Mat3 frame_of(const Tangents& tangents);

// Pressure p (Pa) along the normal, per du dv: p a_u x a_v.
SurfaceForce pressure_load(const Tangents& tangents, double pressure);
SurfaceForceSlopes pressure_load_slopes(const Tangents& tangents, double pressure);

// A force f (N) that keeps its components in the frame of the surface: Q c with the frame Q and the
// components c. A change of the tangents turns it by
//   dw = n (e_2 . da_u) / |a_u| - e_2 (n . da_u) / |a_u|
//        + e_1 (n . da_v - (a_v . e_1) (n . da_u) / |a_u|) / (a_v . e_2):   df = dw x f.
SurfaceForce turning_load(const Tangents& tangents, const Vec3& components);
SurfaceForceSlopes turning_load_slopes(const Tangents& tangents, const Vec3& components);

// A moment M (N m) about an edge along a_u, where the surface lies on the side of a_v. It does work
// on the rotation of the surface about its edge. The rotation is positive if the surface beyond the
// edge would move along n; with nu, the unit normal of the edge in the plane, pointing outwards,
//   d theta = n . dx,nu = ((a_u . a_v) n . da_u / |a_u|^2 - n . da_v) |a_u| / |a_u x a_v|.
SurfaceForce edge_moment(const Tangents& tangents, double moment);
SurfaceForceSlopes edge_moment_slopes(const Tangents& tangents, double moment);

}  // namespace weft::materials
