// Vectors and matrices of three components, as all of sim/ names them.
#pragma once

#include <Eigen/Core>

namespace weft::sim {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

}  // namespace weft::sim
