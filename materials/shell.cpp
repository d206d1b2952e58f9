#include "materials/shell.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace weft::materials {

namespace {

// Returns the inverse of the first fundamental form as the components A^11, A^22 and A^12.
Vec3 inverse_metric(const SurfaceDerivatives& x) {
  const double uu = x.u.dot(x.u), vv = x.v.dot(x.v), uv = x.u.dot(x.v);
  return Vec3(vv, uu, -uv) / (uu * vv - uv * uv);
}

// Returns d_1 and d_2 of a membrane modulus: the parts for the strains along u and v (shell.h).
Eigen::Vector2d separable_moduli(const Mat3& modulus) {
  const Eigen::Vector2d shear = modulus.col(2).head<2>();
  const Eigen::Matrix2d condensed =
      modulus.topLeftCorner<2, 2>() - shear * shear.transpose() / modulus(2, 2);
  const double coupling = std::abs(condensed(0, 1)) / std::sqrt(condensed(0, 0) * condensed(1, 1));
  return (1 - coupling) * condensed.diagonal();
}

}  // namespace

Vec3 second_form(const SurfaceDerivatives& x) {
  const Vec3 normal = x.u.cross(x.v).normalized();
  return {normal.dot(x.uu), normal.dot(x.vv), 2 * normal.dot(x.uv)};
}

Mat3 plane_stress_modulus(const SurfaceDerivatives& rest, double stiffness, double poisson_ratio) {
  const Vec3 inverse = inverse_metric(rest);
  const auto entry = [&](int a, int b) { return a == b ? inverse[a] : inverse[2]; };
  constexpr std::array<std::array<int, 2>, 3> indices{{{0, 0}, {1, 1}, {0, 1}}};
  Mat3 modulus;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const auto [a, b] = indices[i];
      const auto [c, d] = indices[j];
      modulus(i, j) =
          poisson_ratio * entry(a, b) * entry(c, d) +
          0.5 * (1 - poisson_ratio) * (entry(a, c) * entry(b, d) + entry(a, d) * entry(b, c));
    }
  }
  return stiffness / (1 - poisson_ratio * poisson_ratio) * modulus;
}

ShellLaw membrane_law(const SurfaceDerivatives& rest, double youngs_modulus, double poisson_ratio,
                      double thickness, double parameter_area) {
  const double area = parameter_area * area_factor(rest);
  Mat3 modulus = area * plane_stress_modulus(rest, youngs_modulus * thickness, poisson_ratio);
  modulus.diagonal().head<2>() -= separable_moduli(modulus);
  return {metric(rest), modulus};
}

FibreLaw fibre_law(FibreAxis axis, const SurfaceDerivatives& rest, double youngs_modulus,
                   double poisson_ratio, double thickness, double parameter_area) {
  const double area = parameter_area * area_factor(rest);
  const Mat3 modulus = area * plane_stress_modulus(rest, youngs_modulus * thickness, poisson_ratio);
  const int i = axis == FibreAxis::u ? 0 : 1;
  return {metric(rest)[i], separable_moduli(modulus)[i]};
}

ShellLaw bending_law(const SurfaceDerivatives& rest, double youngs_modulus, double poisson_ratio,
                     double thickness, double parameter_area) {
  const double area = parameter_area * area_factor(rest);
  const double stiffness = youngs_modulus * thickness * thickness * thickness / 12;
  return {second_form(rest), area * plane_stress_modulus(rest, stiffness, poisson_ratio)};
}

ShellBend::ShellBend(const SurfaceDerivatives& x) {
  const Vec3 normal = x.u.cross(x.v);
  const double area = normal.norm();
  if (!(area > 0)) {
    for (Vec3* each : {&normal_, &form_, &dual_u_, &dual_v_, &slope_u_, &slope_v_}) each->setZero();
    return;
  }
  normal_ = normal / area;
  dual_u_ = x.v.cross(normal_) / area;
  dual_v_ = normal_.cross(x.u) / area;
  const auto along = [&](const Vec3& direction) {
    return Vec3(direction.dot(x.uu), direction.dot(x.vv), 2 * direction.dot(x.uv));
  };
  form_ = along(normal_);
  slope_u_ = along(dual_u_);
  slope_v_ = along(dual_v_);
}

Vec3 pulling_part(const Vec3& stress) {
  Eigen::Matrix2d tensor;
  tensor << stress[0], stress[2], stress[2], stress[1];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(tensor);
  const Eigen::Vector2d values = solver.eigenvalues().cwiseMax(0);
  const Eigen::Matrix2d pulls =
      solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
  return {pulls(0, 0), pulls(1, 1), pulls(0, 1)};
}

}  // namespace weft::materials
