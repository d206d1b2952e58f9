// Random stencils and fourth-order central differences, the oracle of every derivative here.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>

namespace weft::materials {

// Uniform in [-scale, scale]. Fixed seeds make a failure repeatable.
template <class Matrix>
Matrix random_matrix(std::mt19937& generator, double scale = 1) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  Matrix result;
  for (Eigen::Index i = 0; i < result.size(); ++i) result.data()[i] = uniform(generator);
  return result;
}

// d function / d x for a matrix-valued function of a matrix, both flattened by columns: one column
// of the result per component of x. The error is of the order step^4 + 1e-16 / step.
template <class Function, class Matrix>
Eigen::MatrixXd finite_difference(const Function& function, const Matrix& x, double step = 1e-3) {
  const auto flat = [&](Eigen::Index component, double shift) -> Eigen::VectorXd {
    Matrix moved = x;
    moved.data()[component] += shift;
    const Eigen::MatrixXd value = function(moved);
    return Eigen::Map<const Eigen::VectorXd>(value.data(), value.size());
  };
  Eigen::MatrixXd result(flat(0, 0).size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    result.col(i) =
        (8 * (flat(i, step) - flat(i, -step)) - flat(i, 2 * step) + flat(i, -2 * step)) /
        (12 * step);
  }
  return result;
}

// A scalar as the 1 x 1 matrix that finite_difference takes.
inline Eigen::MatrixXd as_matrix(double value) { return Eigen::MatrixXd::Constant(1, 1, value); }

// |a - b| / |b| over all components (Frobenius).
inline double relative_error(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / b.norm();
}

// Node forces (3 x nodes) as one vector in node-major order.
template <class Nodes>
Eigen::VectorXd flattened(const Nodes& nodes) {
  return Eigen::Map<const Eigen::VectorXd>(nodes.data(), nodes.size());
}

// sum_i x_i x f_i, the moment of node forces about the origin.
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
