// Small fixed-size matrices shared by the materials.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace weft::materials {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
// Node values of a stencil as columns: 3 x nodes. The even-sized types are left unaligned: Eigen's
// alignment depends on the compiler's -march, which a program that links the library may not share.
using Nodes3 = Eigen::Matrix<double, 3, 3>;
using Nodes4 = Eigen::Matrix<double, 3, 4, Eigen::ColMajor | Eigen::DontAlign>;
// Hessians in node-major order: component 3 * node + axis.
using Mat9 = Eigen::Matrix<double, 9, 9>;
using Mat12 = Eigen::Matrix<double, 12, 12, Eigen::ColMajor | Eigen::DontAlign>;

// Eigen's own sums over three components load pairs that were just stored one by one, which stalls
// the processor: these are 2 to 3 times faster where vectors have just been computed.
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double squared_norm(const Vec3& a) { return dot(a, a); }

}  // namespace weft::materials
