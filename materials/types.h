// Small fixed-size matrices shared by the materials.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace weft::materials {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
// Node values of a stencil as columns: 3 x nodes.
using Nodes3 = Eigen::Matrix<double, 3, 3>;
using Nodes4 = Eigen::Matrix<double, 3, 4>;
// Hessians in node-major order: component 3 * node + axis.
using Mat9 = Eigen::Matrix<double, 9, 9>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

}  // namespace weft::materials
