#include "sim/modes/mode_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft::sim {

namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

// Returns |A| |v|.
Vector product_of_magnitudes(const Matrix& a, const Vector& vector) {
  return Matrix(a.cwiseAbs()).selfadjointView<Eigen::Lower>() * vector.cwiseAbs();
}

// Number of rounding errors of positions that may add up in the strain of an edge.
constexpr double strain_roundings = 16;
// Shortest length of an edge, as a fraction of the longest edge at the same particle. Shorter ones
// are ties and seams, whose stiffness depends on no tension.
constexpr double shortest_edge = 0.01;

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

PositionRounding::PositionRounding(const BlockMatrix& stiffness, std::span<const Vec3> position) {
  constexpr double unit = strain_roundings * std::numeric_limits<double>::epsilon();
  const BlockPattern& pattern = stiffness.pattern();
  for (int i = 0; i < pattern.rows(); ++i) {
    double longest = 0;
    for (int slot = pattern.row_begin(i); slot < pattern.row_end(i); ++slot)
      longest = std::max(longest, (position[pattern.column(slot)] - position[i]).norm());
    for (int slot = pattern.row_begin(i); slot < pattern.diagonal_slot(i); ++slot) {
      const int j = pattern.column(slot);
      const double length = std::max((position[j] - position[i]).norm(), shortest_edge * longest);
      const double place = std::max(position[i].norm(), position[j].norm());
      if (!(length > 0)) continue;
      const double largest = stiffness.block(i, slot).cwiseAbs().maxCoeff();
      edges_.push_back({i, j, unit * place / length * largest});
    }
  }
}

double PositionRounding::energy(std::span<const Vec3> shape) const {
  double sum = 0;
  for (const Edge& edge : edges_)
    sum += edge.stiffness * (shape[edge.one] - shape[edge.other]).squaredNorm();
  return sum;
}

}  // namespace weft::sim
