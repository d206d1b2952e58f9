// Bending of cloth whose stiffness depends on the direction and on the curvature. The moduli D act
// on (kappa_11, kappa_22, 2 kappa_12) in the axes of warp and weft. They depend on K = |kappa| =
// sqrt(kappa : kappa). A table gives D at some values of K. D is linear between two of these values
// and constant beyond the largest value. The energy per rest area is the work of the moments D(K)
// kappa on the straight path to kappa:
//   w = int_0^1 kappa : D(t K) t kappa dt = 1/2 kappa : D_mean(K) : kappa,
//   D_mean(K) = 2 / K^2 int_0^K D(k) k dk.
// If the cloth is bent to a cylinder, K is the cylinder's curvature, and the moment is B(K) K. B is
// the stiffness in the direction of the curvature (orthotropic_moduli.h).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "materials/jet.h"
#include "materials/orthotropic_moduli.h"

namespace weft::materials {

class CurvedBending {
 public:
  // Makes the law of a table: `curvatures` lists values of K (1/m), and `moduli` lists the values
  // of D there (N m). Preconditions: both have the same size; the first curvature is zero, and the
  // curvatures increase.
  CurvedBending(std::span<const double> curvatures, std::span<const OrthotropicModuli> moduli);

  // Returns the energy w (N/m) at the curvature (kappa_11, kappa_22, 2 kappa_12), 1/m. `Number` may
  // be any number type (jet.h).
  template <class Number>
  Number energy(const std::array<Number, 3>& curvature) const {
    using Real = decltype(value_of(curvature[0]));
    const std::array<Number, 4> squares{curvature[0] * curvature[0],
                                        2.0 * curvature[0] * curvature[1],
                                        curvature[1] * curvature[1], curvature[2] * curvature[2]};
    const Number size = root(size_squared(squares));
    const Real k = value_of(size);
    std::array<Real, 4> mean, slope, second;
    for (int i = 0; i < 4; ++i) mean[i] = flat_[i], slope[i] = 0.0, second[i] = 0.0;
    for (const Ramp& ramp : ramps_) {
      // The ramp adds `change` times f to D_mean, with f = 2 / K^2 int_0^K (s - start)_+ s ds. The
      // variable k is K; f_slope and f_second are the derivatives of f by K.
      const Real beyond = larger(k - ramp.start, 0.0);
      const Real f = beyond * beyond * (2.0 * k + ramp.start) / (3.0 * k * k);
      const Real f_slope = 2.0 * (beyond - f) / k;
      const Real f_second =
          2.0 * (choose(Real(0.0) < beyond, Real(1.0), Real(0.0)) - 1.5 * f_slope) / k;
      for (int i = 0; i < 4; ++i) {
        mean[i] += ramp.change[i] * f;
        slope[i] += ramp.change[i] * f_slope;
        second[i] += ramp.change[i] * f_second;
      }
    }
    Number sum(0.0);
    for (int i = 0; i < 4; ++i) sum += composed(size, mean[i], slope[i], second[i]) * squares[i];
    return 0.5 * sum;
  }
  // Returns the moduli D(K), N m, at the curvature (kappa_11, kappa_22, 2 kappa_12), 1/m.
  template <class Real>
  Symmetric3Of<Real> semi_definite_moduli(const std::array<Real, 3>& curvature) const {
    const Real k = square_root(size_squared(std::array<Real, 4>{curvature[0] * curvature[0], 0.0,
                                                                curvature[1] * curvature[1],
                                                                curvature[2] * curvature[2]}));
    std::array<Real, 4> d;
    for (int i = 0; i < 4; ++i) d[i] = flat_[i];
    for (const Ramp& ramp : ramps_) {
      const Real beyond = larger(k - ramp.start, 0.0);
      for (int i = 0; i < 4; ++i) d[i] += ramp.change[i] * beyond;
    }
    return {{d[0], d[1], Real(0.0), d[2], Real(0.0), d[3]}};
  }

 private:
  static constexpr double smallest = 1e-6;  // curvature below which K is smoothed, 1/m
  // Returns K^2 + smallest^2, whose square root is smooth at zero. `squares` holds kappa_11^2,
  // 2 kappa_11 kappa_22 (unused), kappa_22^2 and (2 kappa_12)^2.
  template <class Number>
  static Number size_squared(const std::array<Number, 4>& squares) {
    return squares[0] + squares[2] + 0.5 * squares[3] + Number(smallest * smallest);
  }

  // A kink of the table at the curvature `start` (1/m). The derivatives of the moduli (warp,
  // coupling, weft, shear) by K increase there by `change`, N m^2.
  struct Ramp {
    double start;
    std::array<double, 4> change;
  };
  std::array<double, 4> flat_;  // the moduli at zero curvature, N m
  std::vector<Ramp> ramps_;
};

}  // namespace weft::materials
