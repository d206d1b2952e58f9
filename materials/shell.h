// The Kirchhoff-Love shell at a point of its surface: St. Venant-Kirchhoff stretching and bending.
//
// The surface x(u, v) has the tangents a_1 = x_u and a_2 = x_v, the unit normal n = a_1 x a_2 /
// |a_1 x a_2| and the second derivatives a_11, a_22, a_12. With capitals for the rest shape,
//   strain     E_ab = 1/2 (a_a . a_b - A_a . A_b),
//   bending    k_ab = a_ab . n - A_ab . N,
//   energy     W = integral of h/2 E : C : E + h^3/24 k : C : k over the rest area,
//   C^abcd     = Y/(1 - nu^2) [nu A^ab A^cd + (1 - nu)/2 (A^ac A^bd + A^ad A^bc)],
// where A^ab is the inverse rest metric, Y Young's modulus, nu Poisson's ratio and h the thickness
// (Kiendl, Bletzinger, Linhard, Wuechner 2009, Isogeometric shell analysis with Kirchhoff-Love
// elements). The code stores a symmetric tensor as the vector of its components (11, 22, 12). For
// strains and bending, the third component is twice the component 12.
//
// The basis functions N_r of the nodes r give a_1 = sum_r N_r,1 x_r and so on. With the dual
// tangents a^c and G^c_ab = a_ab . a^c,
//   d k_ab / d x_r = (N_r,ab - G^c_ab N_r,c) n = c_r,ab n,
//   m : d^2 k / d x_r d x_s = -c_r g_s n^T - c_s n g_r^T - (m : b) (g_r . g_s) n n^T,
// where m is the tensor of moments, c_r = m : c_r,ab, g_r = N_r,c a^c and b_ab = a_ab . n. These
// derivatives follow from dn = -a^c (n . d a_c) and
// d a^c = -(a^c . d a_e) a^e + a^ce (n . d a_e) n.
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

// First and second derivatives by u and v of the nodes' basis functions at a point.
template <int nodes>
struct ShellBasis {
  using Numbers = Eigen::Array<double, nodes, 1, Eigen::DontAlign>;
  Numbers u, v, uu, vv, uv;
};

// First and second derivatives by u and v of the position (m) or the velocity (m/s) at a point.
struct SurfaceDerivatives {
  Vec3 u, v, uu, vv, uv;
};

template <int nodes>
SurfaceDerivatives derivatives(const ShellBasis<nodes>& basis, const NodesOf<double, nodes>& x) {
  return {x * basis.u.matrix(), x * basis.v.matrix(), x * basis.uu.matrix(), x * basis.vv.matrix(),
          x * basis.uv.matrix()};
}

// A linear law at a quadrature point: the energy is 1/2 e^T modulus e, J. For the membrane, e is
// half the change of the first fundamental form from `rest`. For bending, e is the change of the
// second fundamental form from `rest`. The modulus includes the rest area of the point.
struct ShellLaw {
  Vec3 rest = Vec3::Zero();  // fundamental form of the rest shape, component 12 doubled
  Mat3 modulus = Mat3::Zero();
};

// Returns the first fundamental form (m^2), component 12 doubled.
inline Vec3 metric(const SurfaceDerivatives& x) {
  return {x.u.dot(x.u), x.v.dot(x.v), 2 * x.u.dot(x.v)};
}
// Returns the second fundamental form (m), component 12 doubled.
Vec3 second_form(const SurfaceDerivatives& x);

// Returns the area of the surface (m^2) per area of the parameters u and v.
inline double area_factor(const SurfaceDerivatives& x) { return x.u.cross(x.v).norm(); }

// Returns the matrix M of the tensor (stiffness / Y) C (plane stress). 1/2 e^T M e is the energy
// per rest area of a vector e of strains or bending. `stiffness` is Y h (N/m) for strains and
// Y h^3 / 12 (N m) for bending; -1 < poisson_ratio < 1. Precondition: `rest` has an area.
Mat3 plane_stress_modulus(const SurfaceDerivatives& rest, double stiffness, double poisson_ratio);

// The law of the strain along one parameter line at a quadrature point. Along u, the energy is
// modulus / 2 E_11^2 (J). Along v, E_22 replaces E_11.
struct FibreLaw {
  double rest = 0;     // A_11 along u, A_22 along v, m^2
  double modulus = 0;  // includes the rest area of the point
};
enum class FibreAxis { u, v };

// Return the laws of a quadrature point. `parameter_area` is the weight of the point in u and v,
// `youngs_modulus` is in Pa, `thickness` in m. Precondition: `rest` has an area.
//
// The modulus C of the membrane is the sum of three positive semi-definite parts, which may be
// integrated at different points:
//   C = diag(d_1, 0, 0) + diag(0, d_2, 0) + remainder.
// fibre_law() has the modulus d_1 (along u) or d_2 (along v), and membrane_law() has the remainder.
// Elimination of the shear strain gives S_ij = C_ij - C_i3 C_3j / C_33 for i, j = 1, 2, and
//   d_i = S_ii (1 - |S_12| / sqrt(S_11 S_22)).
// With d_1 and d_2 in the ratio S_11 : S_22, these are the largest values for which the remainder
// is positive semi-definite.
ShellLaw membrane_law(const SurfaceDerivatives& rest, double youngs_modulus, double poisson_ratio,
                      double thickness, double parameter_area);
FibreLaw fibre_law(FibreAxis axis, const SurfaceDerivatives& rest, double youngs_modulus,
                   double poisson_ratio, double thickness, double parameter_area);
ShellLaw bending_law(const SurfaceDerivatives& rest, double youngs_modulus, double poisson_ratio,
                     double thickness, double parameter_area);

// Stretching of a parameter line at a point. `tangent` is the derivative of the position by the
// line's parameter, m. `slope` holds the derivatives of the nodes' basis functions by this
// parameter.
class ShellFibre {
 public:
  explicit ShellFibre(const Vec3& tangent) : tangent_(tangent) {}

  double strain(const FibreLaw& law) const { return 0.5 * (tangent_.squaredNorm() - law.rest); }
  // `rate` is the time derivative of the tangent, m/s.
  double strain_rate(const Vec3& rate) const { return tangent_.dot(rate); }
  // Adds the gradient of the energy by the positions of the nodes, N. `stress` is the product of
  // modulus and strain.
  template <int nodes>
  void add_gradient(double stress, const typename ShellBasis<nodes>::Numbers& slope,
                    NodesOf<double, nodes>& sum) const {
    sum += (stress * tangent_) * slope.matrix().transpose();
  }
  // Adds the Hessian of the energy by the positions of the nodes, N/m. It is the sum of a material
  // part (from `modulus`) and a geometric part (from `stress`).
  template <int nodes>
  void add_stiffness(double modulus, double stress,
                     const typename ShellBasis<nodes>::Numbers& slope,
                     StencilMatrix<double, nodes>& sum) const {
    Mat3 all = modulus * tangent_ * tangent_.transpose();
    all.diagonal().array() += stress;
    for (int r = 0; r < nodes; ++r) {
      for (int s = r; s < nodes; ++s) sum(r, s) += (slope[r] * slope[s]) * all;
    }
  }

 private:
  Vec3 tangent_;
};

// Stretching at a point, in all directions of the surface.
class ShellStretch {
 public:
  explicit ShellStretch(const SurfaceDerivatives& x) : x_(x) {}

  Vec3 strain(const ShellLaw& law) const { return 0.5 * (metric(x_) - law.rest); }
  Vec3 strain_rate(const SurfaceDerivatives& v) const {
    return {x_.u.dot(v.u), x_.v.dot(v.v), x_.u.dot(v.v) + x_.v.dot(v.u)};
  }
  // Adds the gradient of the energy by the positions of the nodes, N. `stress` is the product of
  // modulus and strain.
  template <int nodes>
  void add_gradient(const Vec3& stress, const ShellBasis<nodes>& basis,
                    NodesOf<double, nodes>& sum) const {
    sum += x_.u * (stress[0] * basis.u + stress[2] * basis.v).matrix().transpose();
    sum += x_.v * (stress[2] * basis.u + stress[1] * basis.v).matrix().transpose();
  }
  // Adds the Hessian of the energy by the positions of the nodes, N/m. It is the sum of a material
  // part (from `modulus`) and a geometric part (from `stress`).
  template <int nodes>
  void add_stiffness(const Mat3& modulus, const Vec3& stress, const ShellBasis<nodes>& basis,
                     StencilMatrix<double, nodes>& sum) const;

 private:
  SurfaceDerivatives x_;
};

// Bending at a point. At a point without area, the normal, gradient and Hessian are zero.
class ShellBend {
 public:
  explicit ShellBend(const SurfaceDerivatives& x);

  Vec3 bending(const ShellLaw& law) const { return form_ - law.rest; }
  Vec3 bending_rate(const SurfaceDerivatives& v) const {
    Vec3 rate(normal_.dot(v.uu), normal_.dot(v.vv), 2 * normal_.dot(v.uv));
    return rate - slope_u_ * normal_.dot(v.u) - slope_v_ * normal_.dot(v.v);
  }
  template <int nodes>
  void add_gradient(const Vec3& moment, const ShellBasis<nodes>& basis,
                    NodesOf<double, nodes>& sum) const {
    sum += normal_ * turned(moment, basis).matrix().transpose();
  }
  // Adds the Hessian of the energy by the positions of the nodes, N/m. Its material part (from
  // `modulus`) is positive semi-definite. Its geometric part (from `moment`) is added if `exact`.
  template <int nodes>
  void add_stiffness(const Mat3& modulus, const Vec3& moment, bool exact,
                     const ShellBasis<nodes>& basis, StencilMatrix<double, nodes>& sum) const;

 private:
  // Returns c_r = m : c_r,ab for every node r, with the moments m.
  template <int nodes>
  typename ShellBasis<nodes>::Numbers turned(const Vec3& moment,
                                             const ShellBasis<nodes>& basis) const {
    return moment[0] * basis.uu + moment[1] * basis.vv + (2 * moment[2]) * basis.uv -
           moment.dot(slope_u_) * basis.u - moment.dot(slope_v_) * basis.v;
  }

  Vec3 normal_, form_;      // n, and the second fundamental form b_ab with component 12 doubled
  Vec3 dual_u_, dual_v_;    // dual tangents a^1 and a^2
  Vec3 slope_u_, slope_v_;  // G^1_ab and G^2_ab, component 12 doubled
};

template <int nodes>
void ShellStretch::add_stiffness(const Mat3& modulus, const Vec3& stress,
                                 const ShellBasis<nodes>& basis,
                                 StencilMatrix<double, nodes>& sum) const {
  // The derivative of the strain by the position of node r is R_r (a_1, a_2)^T. With the
  // derivatives N_u and N_v of the node's basis function, R_r has the rows (N_u, 0), (0, N_v) and
  // (N_v, N_u).
  using Pairs = Eigen::Matrix<double, 3, 2>;
  const Mat3 uu = x_.u * x_.u.transpose(), vv = x_.v * x_.v.transpose();
  const Mat3 uv = x_.u * x_.v.transpose();
  for (int r = 0; r < nodes; ++r) {
    Pairs row;
    row << basis.u[r], 0, 0, basis.v[r], basis.v[r], basis.u[r];
    const Eigen::Matrix<double, 2, 3> left = row.transpose() * modulus;
    const double along_u = stress[0] * basis.u[r] + stress[2] * basis.v[r];
    const double along_v = stress[2] * basis.u[r] + stress[1] * basis.v[r];
    for (int s = r; s < nodes; ++s) {
      const double nu = basis.u[s], nv = basis.v[s];
      const double q00 = left(0, 0) * nu + left(0, 2) * nv, q01 = left(0, 1) * nv + left(0, 2) * nu;
      const double q10 = left(1, 0) * nu + left(1, 2) * nv, q11 = left(1, 1) * nv + left(1, 2) * nu;
      Mat3& block = sum(r, s);
      block += q00 * uu + q01 * uv + q10 * uv.transpose() + q11 * vv;
      block.diagonal().array() += along_u * nu + along_v * nv;
    }
  }
}

template <int nodes>
void ShellBend::add_stiffness(const Mat3& modulus, const Vec3& moment, bool exact,
                              const ShellBasis<nodes>& basis,
                              StencilMatrix<double, nodes>& sum) const {
  using Rows = Eigen::Matrix<double, 3, nodes, Eigen::ColMajor | Eigen::DontAlign>;
  Rows slopes;  // c_r,ab, component 12 doubled
  for (int i = 0; i < 3; ++i) {
    const auto& second = i == 0 ? basis.uu : i == 1 ? basis.vv : basis.uv;
    slopes.row(i) =
        ((i == 2 ? 2.0 : 1.0) * second - slope_u_[i] * basis.u - slope_v_[i] * basis.v).matrix();
  }
  const Rows products = modulus * slopes;
  const Mat3 normals = normal_ * normal_.transpose();
  if (!exact) {
    for (int r = 0; r < nodes; ++r) {
      for (int s = r; s < nodes; ++s) sum(r, s) += slopes.col(r).dot(products.col(s)) * normals;
    }
    return;
  }
  const typename ShellBasis<nodes>::Numbers pulls = turned(moment, basis);
  const Rows gradients =
      dual_u_ * basis.u.matrix().transpose() + dual_v_ * basis.v.matrix().transpose();
  const double contracted = moment.dot(form_);
  for (int r = 0; r < nodes; ++r) {
    for (int s = r; s < nodes; ++s) {
      const double half = 0.5 * (slopes.col(r).dot(products.col(s)) -
                                 contracted * gradients.col(r).dot(gradients.col(s)));
      const Vec3 left = half * normal_ - pulls[r] * gradients.col(s);
      const Vec3 right = half * normal_ - pulls[s] * gradients.col(r);
      sum(r, s) += left * normal_.transpose() + normal_ * right.transpose();
    }
  }
}

// Returns a stress without its compression: negative eigenvalues of the 2 x 2 tensor are set to
// zero. Argument and result hold the components (11, 22, 12).
Vec3 pulling_part(const Vec3& stress);

}  // namespace weft::materials
