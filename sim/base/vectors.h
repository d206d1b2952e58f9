// Three-dimensional vectors and matrices, under the names that sim/ uses.
#pragma once

#include <Eigen/Core>

namespace weft::sim {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

}  // namespace weft::sim
