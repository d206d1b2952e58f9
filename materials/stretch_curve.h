// Membranes of woven cloth by tabulated curves: tension against stretch along the warp, tension
// against stretch along the weft, and shear force against shear.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "materials/jet.h"
#include "materials/types.h"

namespace weft::materials {

// A force per width (N/m) as a function of a strain. It is linear between the points of a table,
// goes on straight beyond them, and is zero at zero strain.
class TensionCurve {
 public:
  // Preconditions: at least two points; strains increase and tensions (N/m) do not fall; one of the
  // points is (0, 0). If all other points lie on one side of zero, the first slope on that side
  // holds for the whole other side.
  TensionCurve(std::span<const double> strains, std::span<const double> tensions);
  // Returns the curve of points from zero on, with its mirror image for strains below zero.
  // Preconditions as above.
  static TensionCurve mirrored(std::span<const double> strains, std::span<const double> tensions);
  // A straight line through zero with the slope `stiffness`, N/m.
  explicit TensionCurve(double stiffness) : pull_{{0, stiffness}}, push_{{0, stiffness}} {}

  // Returns the energy per area (N/m), the integral of the tension from zero to `strain`, for any
  // number type (jet.h).
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
    // At zero itself the curve has the slope of its stretched side.
    slope += choose(value == Real(0.0), Real(pull_.front().slope), Real(0.0));
    return composed(strain, sum, tension, slope);
  }
  // Largest slope of the curve, N/m.
  double largest_stiffness() const;

 private:
  // A kink of the curve, at the distance `start` from zero on the side of its list. The slope of
  // the curve increases by `slope` there, N/m.
  struct Ramp {
    double start, slope;
  };
  static std::vector<Ramp> ramps(std::span<const std::array<double, 2>> points);

  std::vector<Ramp> pull_, push_;
};

// A membrane with independent curves for warp, weft and shear. The energy per rest area is
//   w = w_1(lambda_1 - 1) + w_2(lambda_2 - 1) + w_3(2 E_12),
// where lambda_i = sqrt(1 + 2 E_ii) is the stretch of the threads and the w_i' are the curves. In a
// pull along the warp or the weft the force per rest width is therefore the curve itself, whether
// the other sides are free or held. In a simple shear 2 E_12 is the tangent of the angle, and the
// curve is the shear force per length. There is no Poisson effect.
struct CurvedStretch {
  TensionCurve warp, weft, shear;

  // Returns w (N/m) at (E_11, E_22, 2 E_12), for any number type.
  template <class Number>
  Number energy(const std::array<Number, 3>& strain) const {
    return warp.energy(nominal(strain[0])) + weft.energy(nominal(strain[1])) +
           shear.energy(strain[2]);
  }
  // Returns the second derivatives of w, N/m. Negative ones are replaced by zero.
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
  // Returns lambda - 1, with lambda at least a millionth.
  template <class Number>
  static Number nominal(const Number& green) {
    return root(at_least(Number(1.0) + 2.0 * green, 1e-12)) - Number(1.0);
  }
};

}  // namespace weft::materials
