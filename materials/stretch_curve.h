// Membranes of woven cloth with tabulated curves. Two curves give the tension as a function of the
// stretch, one along the warp and one along the weft. A third curve gives the shear force as a
// function of the shear.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "materials/jet.h"
#include "materials/types.h"

namespace weft::materials {

// A force per width (N/m) as a function of a strain. It is zero at zero strain and linear between
// the points of a table. Beyond the outermost points, it continues with the slope of the last
// interval.
class TensionCurve {
 public:
  // Makes the curve through the points (strains[i], tensions[i]). Tensions are in N/m.
  // Preconditions: there are at least two points; strains increase and tensions do not decrease;
  // one of the points is (0, 0). If there are no points on one side of zero, the curve is a
  // straight line there, with the slope of the other side at zero.
  TensionCurve(std::span<const double> strains, std::span<const double> tensions);
  // Returns the curve through these points of strain >= 0 and, for negative strains, their mirror
  // images (-strain, -tension). The preconditions are those of the constructor.
  static TensionCurve mirrored(std::span<const double> strains, std::span<const double> tensions);
  // Makes a straight line through zero with the slope `stiffness`, N/m.
  explicit TensionCurve(double stiffness) : pull_{{0, stiffness}}, push_{{0, stiffness}} {}

  // Returns the energy per area (N/m): the integral of the tension from zero to `strain`. `Number`
  // may be any number type (jet.h).
  template <class Number>
  Number energy(const Number& strain) const {
    using Real = decltype(value_of(strain));
    const Real value = value_of(strain);
    Real sum = 0.0, tension = 0.0, slope = 0.0;
    const auto add = [&](const Ramp& ramp, const Real& distance, double sign) {
      const Real beyond = larger(distance, 0.0);
      sum += 0.5 * ramp.slope * beyond * beyond;
      tension += sign * ramp.slope * beyond;
      slope += choose(Real(0.0) < distance, Real(ramp.slope), Real(0.0));
    };
    for (const Ramp& ramp : pull_) add(ramp, value - ramp.start, 1);
    for (const Ramp& ramp : push_) add(ramp, -value - ramp.start, -1);
    // At zero itself, the slope is that of positive strains.
    slope += choose(value == Real(0.0), Real(pull_.front().slope), Real(0.0));
    return composed(strain, sum, tension, slope);
  }
  // Returns the largest slope of the curve, N/m.
  double largest_stiffness() const;

 private:
  // A kink of the curve at the strain `start` (in pull_) or -start (in push_). The slope of the
  // curve beyond the kink, as seen from zero, exceeds the slope before the kink by `slope` (N/m).
  // The first kink is at zero, and its `slope` is that of the first interval.
  struct Ramp {
    double start, slope;
  };
  static std::vector<Ramp> ramps(std::span<const std::array<double, 2>> points);

  std::vector<Ramp> pull_, push_;
};

// A membrane with independent curves for warp, weft and shear. The energy per rest area is
//   w = w_1(lambda_1 - 1) + w_2(lambda_2 - 1) + w_3(2 E_12),
// where lambda_i = sqrt(1 + 2 E_ii) is the stretch of the threads and the derivatives w_i' are the
// curves. In a pull along the warp or the weft, the force per rest width is therefore the curve of
// that axis. The contraction across the pull has no influence: there is no Poisson effect. In a
// simple shear, 2 E_12 is the tangent of the shear angle. The curve is then the shear force per
// length, except for the part from the stretch of the sheared threads.
struct CurvedStretch {
  TensionCurve warp, weft, shear;

  // Returns the energy w (N/m) at the strain (E_11, E_22, 2 E_12). `Number` may be any number type
  // (jet.h).
  template <class Number>
  Number energy(const std::array<Number, 3>& strain) const {
    return warp.energy(nominal(strain[0])) + weft.energy(nominal(strain[1])) +
           shear.energy(strain[2]);
  }
  // Returns the second derivatives of w (N/m) at the strain (E_11, E_22, 2 E_12). They form a
  // diagonal matrix. Negative entries are replaced by zero.
  template <class Real>
  Symmetric3Of<Real> semi_definite_moduli(const std::array<Real, 3>& strain) const {
    using Number = Jet<Real, 2>;
    std::array<Number, 3> at;
    for (int i = 0; i < 3; ++i) at[i] = Number::variable(strain[i], i);
    const Number w = energy(at);
    Symmetric3Of<Real> moduli;
    moduli.entries.fill(0.0);
    for (int i = 0; i < 3; ++i) {
      const int k = Symmetric3Of<Real>::index(i, i);
      moduli.entries[k] = larger(w.second[k], 0.0);
    }
    return moduli;
  }

 private:
  // Returns lambda - 1 from E. lambda is at least 1e-6.
  template <class Number>
  static Number nominal(const Number& green) {
    return root(at_least(Number(1.0) + 2.0 * green, 1e-12)) - Number(1.0);
  }
};

}  // namespace weft::materials
