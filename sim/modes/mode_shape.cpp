#include "sim/modes/mode_shape.h"

#include <cmath>

namespace weft::sim {

namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

// Returns |A| |v|.
Vector product_of_magnitudes(const Matrix& a, const Vector& vector) {
  return Matrix(a.cwiseAbs()).selfadjointView<Eigen::Lower>() * vector.cwiseAbs();
}

}  // namespace

std::vector<Vec3> shape_of(const ModeUnknowns& unknowns, const Vector& vector) {
  std::vector<Vec3> shape(unknowns.particle_count());
  unknowns.scatter(vector, shape);
  double largest = 0;
  for (const Vec3& each : shape) largest = std::max(largest, each.norm());
  Eigen::Index steepest = 0;
  vector.cwiseAbs().maxCoeff(&steepest);
  const double scale = std::copysign(1 / largest, vector[steepest]);
  for (Vec3& each : shape) each *= scale;
  return shape;
}

double equation_error(const Matrix& a, const Matrix& b, double value, const Vector& vector) {
  const Vector left = a.selfadjointView<Eigen::Lower>() * vector;
  const Vector right = b.selfadjointView<Eigen::Lower>() * vector;
  return (left - value * right).norm() / product_of_magnitudes(a, vector).norm();
}

double rounding_scale(const Matrix& a, const Vector& vector) {
  return vector.cwiseAbs().dot(product_of_magnitudes(a, vector));
}

}  // namespace weft::sim
