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

}  // namespace weft::materials
