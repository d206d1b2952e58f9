// Three-dimensional vectors and matrices, under the names that sim/ uses.
#pragma once

#include <Eigen/Core>
#include <span>

namespace weft::sim {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

// Returns a view of the vectors' components: three numbers per vector.
inline std::span<const double> numbers_of(std::span<const Vec3> vectors) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  return {reinterpret_cast<const double*>(vectors.data()), 3 * vectors.size()};
}

}  // namespace weft::sim
