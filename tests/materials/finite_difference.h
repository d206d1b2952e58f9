// Random stencils and central differences, the oracle of all derivatives here.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>

#include "tests/dense_algebra.h"

namespace weft::materials {

// Uniform in [-scale, scale]. Fixed seeds make a failure repeatable.
template <class Matrix>
Matrix random_matrix(std::mt19937& generator, double scale = 1) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  Matrix result;
  for (Eigen::Index i = 0; i < result.size(); ++i) result.data()[i] = uniform(generator);
  return result;
}

// d function / d x for a matrix-valued function of a matrix (tests/dense_algebra.h).
template <class Function, class Matrix>
Eigen::MatrixXd finite_difference(const Function& function, const Matrix& x, double step = 1e-3) {
  return flat_finite_difference(
      [&](const Eigen::VectorXd& moved) -> Eigen::MatrixXd {
        return function(Matrix(Eigen::Map<const Matrix>(moved.data())));
      },
      Eigen::Map<const Eigen::VectorXd>(x.data(), x.size()), step);
}

// A scalar as the 1 x 1 matrix that finite_difference takes.
inline Eigen::MatrixXd as_matrix(double value) { return Eigen::MatrixXd::Constant(1, 1, value); }

// Node forces (3 x nodes) as one vector in node-major order.
template <class Nodes>
Eigen::VectorXd flattened(const Nodes& nodes) {
  return Eigen::Map<const Eigen::VectorXd>(nodes.data(), nodes.size());
}

// Returns the moment of node forces about the origin, sum_i x_i x f_i.
template <class Nodes>
Eigen::Vector3d torque(const Nodes& x, const Nodes& forces) {
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    total += Eigen::Vector3d(x.col(i)).cross(Eigen::Vector3d(forces.col(i)));
  }
  return total;
}

// The velocities of a rigid motion: v_i = v + omega x x_i.
template <class Nodes>
Nodes rigid_velocity(const Nodes& x, const Eigen::Vector3d& velocity,
                     const Eigen::Vector3d& omega) {
  Nodes result;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    result.col(i) = velocity + omega.cross(Eigen::Vector3d(x.col(i)));
  }
  return result;
}

}  // namespace weft::materials
