// Small fixed-size matrices of `double` or of `Lanes` (materials/lanes.h), which the materials
// share.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "materials/lanes.h"

namespace weft::materials {

template <class Real>
using Vec3Of = Eigen::Matrix<Real, 3, 1>;
template <class Real>
using Mat3Of = Eigen::Matrix<Real, 3, 3>;
// Vectors at the nodes of a stencil, as columns. The type is not aligned: Eigen's alignment depends
// on the compiler's -march, which may differ between the library and a program that links it.
template <class Real, int nodes>
using NodesOf = Eigen::Matrix<Real, 3, nodes, Eigen::ColMajor | Eigen::DontAlign>;

using Vec3 = Vec3Of<double>;
using Mat3 = Mat3Of<double>;
using Nodes3 = NodesOf<double, 3>;
using Nodes4 = NodesOf<double, 4>;

// Return the dot product and the squared norm of vectors of three components. Eigen's own functions
// load pairs of numbers, which stalls the processor if the numbers were just stored one by one. For
// vectors just computed, the functions here are 2 to 3 times faster.
template <class A, class B>
auto dot(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return typename A::Scalar(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}
template <class A>
auto squared_norm(const Eigen::MatrixBase<A>& a) {
  return dot(a, a);
}
// Returns a b^T.
template <class Real>
Mat3Of<Real> outer(const Vec3Of<Real>& a, const Vec3Of<Real>& b) {
  return a * b.transpose();
}

// A symmetric 3 x 3 matrix. It stores the upper triangle, row by row.
template <class Real>
struct Symmetric3Of {
  std::array<Real, 6> entries;

  static constexpr int index(int i, int j) {
    return i <= j ? i * 3 - i * (i + 1) / 2 + j : index(j, i);
  }
  const Real& operator()(int i, int j) const { return entries[index(i, j)]; }
  Real& operator()(int i, int j) { return entries[index(i, j)]; }
  Symmetric3Of scaled(const Real& factor) const {
    Symmetric3Of result = *this;
    for (Real& entry : result.entries) entry *= factor;
    return result;
  }
  Symmetric3Of& operator+=(const Symmetric3Of& other) {
    for (std::size_t i = 0; i < entries.size(); ++i) entries[i] += other.entries[i];
    return *this;
  }
  Vec3Of<Real> operator*(const Vec3Of<Real>& a) const {
    const auto& c = entries;
    return {c[0] * a[0] + c[1] * a[1] + c[2] * a[2], c[1] * a[0] + c[3] * a[1] + c[4] * a[2],
            c[2] * a[0] + c[4] * a[1] + c[5] * a[2]};
  }
};

// A symmetric matrix over the nodes of a stencil. It stores the 3 x 3 blocks on and above the
// diagonal, row by row.
template <class Real, int nodes>
struct StencilMatrix {
  std::array<Mat3Of<Real>, nodes*(nodes + 1) / 2> blocks;

  static constexpr int index(int row, int column) {  // precondition: row <= column
    return row * nodes - row * (row + 1) / 2 + column;
  }
  Mat3Of<Real>& operator()(int row, int column) { return blocks[index(row, column)]; }
  const Mat3Of<Real>& operator()(int row, int column) const { return blocks[index(row, column)]; }

  void scale(const Real& factor) {
    for (Mat3Of<Real>& block : blocks) block *= factor;
  }
  StencilMatrix scaled(const Real& factor) const {
    StencilMatrix result = *this;
    result.scale(factor);
    return result;
  }

  // Returns the whole matrix in node-major order: component 3 * node + axis.
  Eigen::Matrix<Real, 3 * nodes, 3 * nodes> dense() const {
    Eigen::Matrix<Real, 3 * nodes, 3 * nodes> all;
    for (int a = 0; a < nodes; ++a) {
      for (int b = a; b < nodes; ++b) {
        all.template block<3, 3>(3 * b, 3 * a) = (*this)(a, b).transpose();
        all.template block<3, 3>(3 * a, 3 * b) = (*this)(a, b);
      }
    }
    return all;
  }
};

}  // namespace weft::materials
