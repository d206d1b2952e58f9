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
// elements). Tensors are written as vectors of their components (11, 22, 12); strains and bending
// have twice their component 12.
//
// Nodes enter by the derivatives of their basis functions: a_1 = sum_r N_r,1 x_r and so on. With
// a^c the dual tangents and G^c_ab = a_ab . a^c,
//   d k_ab / d x_r = (N_r,ab - G^c_ab N_r,c) n = c_r,ab n,
//   m : d^2 k / d x_r d x_s = -c_r g_s n^T - c_s n g_r^T - (m : b) (g_r . g_s) n n^T,
// where m is the tensor of moments, c_r = m : c_r,ab, g_r = N_r,c a^c and b_ab = a_ab . n. This
// follows from dn = -a^c (n . d a_c) and d a^c = -(a^c . d a_e) a^e + a^ce (n . d a_e) n.
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

// Derivatives of the basis functions of the nodes at a point.
template <int nodes>
struct ShellBasis {
  using Numbers = Eigen::Array<double, nodes, 1, Eigen::DontAlign>;
  Numbers u, v, uu, vv, uv;
};

// Derivatives of positions (m), or of velocities (m/s), at a point.
struct SurfaceDerivatives {
  Vec3 u, v, uu, vv, uv;
};

template <int nodes>
SurfaceDerivatives derivatives(const ShellBasis<nodes>& basis, const NodesOf<double, nodes>& x) {
  return {x * basis.u.matrix(), x * basis.v.matrix(), x * basis.uu.matrix(), x * basis.vv.matrix(),
          x * basis.uv.matrix()};
}

// A linear law at a point: the energy is 1/2 e^T modulus e, where e is the change of `rest`. The
// modulus includes the area of the point.
struct ShellLaw {
  Vec3 rest = Vec3::Zero();  // first or second fundamental form, component 12 twice
  Mat3 modulus = Mat3::Zero();
};

// First fundamental form (m^2), component 12 twice.
inline Vec3 metric(const SurfaceDerivatives& x) {
  return {x.u.dot(x.u), x.v.dot(x.v), 2 * x.u.dot(x.v)};
}
// Second fundamental form (m), component 12 twice.
Vec3 second_form(const SurfaceDerivatives& x);

// Area (m^2) per area of the parameters.
inline double area_factor(const SurfaceDerivatives& x) { return x.u.cross(x.v).norm(); }

// Returns the tensor C of a plane in stress over strains as vectors. `rest` has an area; stiffness
// is Y h (N/m), -1 < poisson_ratio < 1. The result is in N/m over strains without unit.
Mat3 plane_stress_modulus(const SurfaceDerivatives& rest, double stiffness, double poisson_ratio);

// The law of the strain along one parameter line at a point: the energy is modulus / 2 E_11^2 (or
// E_22^2).
struct FibreLaw {
  double rest = 0;     // A_11 (or A_22), m^2
  double modulus = 0;  // includes the area of the point
};
enum class FibreAxis { u, v };

// Returns the laws of a point whose weight is `parameter_area`. The modulus C of the membrane is
// the sum of three positive semi-definite parts, which may be integrated at different points: those
// of the strains along u and along v alone, d_1 and d_2, and the rest. With the shear condensed,
// S_ij = C_ij - C_i3 C_3j / C_33 for i, j = 1, 2, the first two are as large as they can be in
// proportion:
//   d_i = S_ii (1 - |S_12| / sqrt(S_11 S_22)),   C = diag(d_1, d_2, 0) + rest.
ShellLaw membrane_law(const SurfaceDerivatives& rest, double youngs_modulus, double poisson_ratio,
                      double thickness, double parameter_area);
FibreLaw fibre_law(FibreAxis axis, const SurfaceDerivatives& rest, double youngs_modulus,
                   double poisson_ratio, double thickness, double parameter_area);
ShellLaw bending_law(const SurfaceDerivatives& rest, double youngs_modulus, double poisson_ratio,
                     double thickness, double parameter_area);

// Stretching of a parameter line at a point, where the line has this tangent. `slope` holds the
// derivatives of the basis functions along it.
class ShellFibre {
 public:
  explicit ShellFibre(const Vec3& tangent) : tangent_(tangent) {}

  double strain(const FibreLaw& law) const { return 0.5 * (tangent_.squaredNorm() - law.rest); }
  // `rate`: the change of the tangent with time, m/s.
  double strain_rate(const Vec3& rate) const { return tangent_.dot(rate); }
  // Adds minus the forces (N) of a stress, modulus times strain, to the nodes.
  template <int nodes>
  void add_gradient(double stress, const typename ShellBasis<nodes>::Numbers& slope,
                    NodesOf<double, nodes>& sum) const {
    sum += (stress * tangent_) * slope.matrix().transpose();
  }
  // Adds the Hessian: of the modulus, and of the stress.
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
  // Adds minus the forces (N) of a stress, modulus times strain, to the nodes.
  template <int nodes>
  void add_gradient(const Vec3& stress, const ShellBasis<nodes>& basis,
                    NodesOf<double, nodes>& sum) const {
    sum += x_.u * (stress[0] * basis.u + stress[2] * basis.v).matrix().transpose();
    sum += x_.v * (stress[2] * basis.u + stress[1] * basis.v).matrix().transpose();
  }
  // Adds the Hessian: of the modulus, and of the stress.
  template <int nodes>
  void add_stiffness(const Mat3& modulus, const Vec3& stress, const ShellBasis<nodes>& basis,
                     StencilMatrix<double, nodes>& sum) const;

 private:
  SurfaceDerivatives x_;
};

// Bending at a point. A surface without area has no normal: bending is zero there.
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
  // Adds the Hessian: of the modulus, and of the moment if `exact`.
  template <int nodes>
  void add_stiffness(const Mat3& modulus, const Vec3& moment, bool exact,
                     const ShellBasis<nodes>& basis, StencilMatrix<double, nodes>& sum) const;

 private:
  // c_r = m : c_r,ab by node.
  template <int nodes>
  typename ShellBasis<nodes>::Numbers turned(const Vec3& moment,
                                             const ShellBasis<nodes>& basis) const {
    return moment[0] * basis.uu + moment[1] * basis.vv + (2 * moment[2]) * basis.uv -
           moment.dot(slope_u_) * basis.u - moment.dot(slope_v_) * basis.v;
  }

  Vec3 normal_, form_;
  Vec3 dual_u_, dual_v_;    // a^1, a^2
  Vec3 slope_u_, slope_v_;  // G^1_ab, G^2_ab, component 12 twice
};

template <int nodes>
void ShellStretch::add_stiffness(const Mat3& modulus, const Vec3& stress,
                                 const ShellBasis<nodes>& basis,
                                 StencilMatrix<double, nodes>& sum) const {
  // The strain's slope at node r is R_r (a_1, a_2)^T with the rows (N_u, 0), (0, N_v), (N_v, N_u).
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
  Rows slopes;  // c_r,ab, component 12 twice
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

// Returns the nearest stress that pulls in all directions: its compressions are left out.
Vec3 pulling_part(const Vec3& stress);

}  // namespace weft::materials
