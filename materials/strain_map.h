// Laws of elasticity over the strains of a triangle. A `Law` is a type with two members. energy()
// returns the energy w per rest area (N/m) at a strain e of three components, for any number type
// (jet.h). semi_definite_moduli() returns positive semi-definite moduli V close to the second
// derivatives of w:
//   template <class Number> Number energy(const std::array<Number, 3>& e) const;
//   template <class Real> Symmetric3Of<Real> semi_definite_moduli(const std::array<Real, 3>& e)
//       const;
// e may be a Green strain (V in N/m), as in CurvedStretch and MeasuredStretch, or a curvature (V in
// N m), as in CurvedBending. LinearLaw serves for both kinds of strain.
#pragma once

#include "materials/jet.h"
#include "materials/orthotropic_moduli.h"
#include "materials/types.h"

namespace weft::materials {

// The map e = B q from three numbers q of a triangle to its strain, with the rest area A. q holds
// the changes of the squared edge lengths (for a Green strain) or of the angles at the edges (for a
// curvature).
template <class Real>
struct StrainMapOf {
  Mat3Of<Real> map = Mat3Of<Real>::Zero();  // B
  Real area = 0;                            // A, m^2

  std::array<Real, 3> strain(const Vec3Of<Real>& q) const {
    std::array<Real, 3> strain;
    for (int i = 0; i < 3; ++i) strain[i] = map(i, 0) * q[0] + map(i, 1) * q[1] + map(i, 2) * q[2];
    return strain;
  }
  // Returns A B^T stress. For the stress dw/de, it is the derivative of the energy A w by q.
  Vec3Of<Real> by_q(const std::array<Real, 3>& stress) const {
    Vec3Of<Real> result;
    for (int i = 0; i < 3; ++i)
      result[i] = area * (map(0, i) * stress[0] + map(1, i) * stress[1] + map(2, i) * stress[2]);
    return result;
  }
  // Returns A B^T M B for the matrix M of `moduli`.
  Symmetric3Of<Real> by_q(const Symmetric3Of<Real>& moduli) const {
    Symmetric3Of<Real> result;
    for (int j = 0; j < 3; ++j) {
      const Vec3Of<Real> column = area * (moduli * Vec3Of<Real>(map(0, j), map(1, j), map(2, j)));
      for (int i = 0; i <= j; ++i)
        result(i, j) = map(0, i) * column[0] + map(1, i) * column[1] + map(2, i) * column[2];
    }
    return result;
  }
};

// The law w = 1/2 e^T M e, where M is the matrix of `moduli`.
struct LinearLaw {
  OrthotropicModuli moduli;

  template <class Number>
  Number energy(const std::array<Number, 3>& e) const {
    return 0.5 * (moduli.warp * (e[0] * e[0]) + 2.0 * moduli.coupling * (e[0] * e[1]) +
                  moduli.weft * (e[1] * e[1]) + moduli.shear * (e[2] * e[2]));
  }
  template <class Real>
  Symmetric3Of<Real> semi_definite_moduli(const std::array<Real, 3>& /*e*/) const {
    return {{moduli.warp, moduli.coupling, 0.0, moduli.weft, 0.0, moduli.shear}};
  }
};

// Returns w at a strain with its derivatives by the strain up to `order` (1 or 2).
template <int order, class Law, class Real>
Jet<Real, order> energy_jet(const Law& law, const std::array<Real, 3>& strain) {
  std::array<Jet<Real, order>, 3> at;
  for (int i = 0; i < 3; ++i) at[i] = Jet<Real, order>::variable(strain[i], i);
  return law.energy(at);
}

// The energy of a triangle and its derivatives by q. law_energy() returns W = A w(B q), J.
// law_slope() returns dW/dq. law_viscosity() returns A B^T V B. law_tangent() returns
// d^2 W/dq dq or, if `semi_definite`, A B^T V B.
template <class Real, class Law>
Real law_energy(const StrainMapOf<Real>& strains, const Law& law, const Vec3Of<Real>& q) {
  return strains.area * law.energy(strains.strain(q));
}
template <class Real, class Law>
Vec3Of<Real> law_slope(const StrainMapOf<Real>& strains, const Law& law, const Vec3Of<Real>& q) {
  return strains.by_q(energy_jet<1>(law, strains.strain(q)).first);
}
template <class Real, class Law>
Symmetric3Of<Real> law_viscosity(const StrainMapOf<Real>& strains, const Law& law,
                                 const Vec3Of<Real>& q) {
  return strains.by_q(law.semi_definite_moduli(strains.strain(q)));
}
template <class Real, class Law>
Symmetric3Of<Real> law_tangent(const StrainMapOf<Real>& strains, const Law& law,
                               const Vec3Of<Real>& q, bool semi_definite) {
  if (semi_definite) return law_viscosity(strains, law, q);
  return strains.by_q(Symmetric3Of<Real>{energy_jet<2>(law, strains.strain(q)).second});
}

}  // namespace weft::materials
