// Membranes of measured cloth. The stiffness is that of Wang, O'Brien and Ramamoorthi 2011
// (Data-driven elastic models for cloth), as the simulator ARCSim interpolates it. Unlike theirs,
// the tensions here are derived from an energy.
//
// The measured tensions are S = C(s, phi) E, where E is the Green strain in the axes of warp and
// weft and C = [11 12 0; 12 22 0; 0 0 33] acts on (E_11, E_22, E_12). C depends on the major
// principal stretch lambda_1 and on its angle phi to the warp,
//   C = (1 - s) C_0 + s C_1(phi),   s = min(6 (lambda_1 - 1), 1), or 0 for lambda_1 < 1.
// C_1 is given at phi = 0, 22.5, 45, 67.5 and 90 degrees. The tensions S do not derive from an
// energy: their work on a closed path is not zero. The energy per rest area here is the work of S
// on the straight path to E,
//   w = int_0^1 E : S(t E) dt = 1/2 E : [C_0 + h (C_1 - C_0)] : E,   h = int_0^1 2 t s(t E) dt.
// Hence E : dw/dE = E : S(E), before the changes of w described below. If only one direction is
// stretched and the width is held, the force is that of S. If warp and weft are stretched equally,
// the sum of both forces is that of S.
//
// The tensions S jump where phi jumps. The four changes below make w smooth. e_1 >= e_2 are the
// principal strains and q = (e_1 - e_2) / (e_1 + e_2). Both directions are stretched if q < 1.
// - C_1 passes through its five values as a polynomial in cos 2 phi, sum_j a_j cos 2 j phi.
// - For q < 1, a_j is multiplied by r^j with r = (15 q - 10 q^3 + 3 q^5) / 8. If the stretch is
//   equal in all directions, phi is undefined; then r = 0, and C_1 is the mean a_0.
// - For q < 1, s is computed from e_1 + (e_1 + e_2) (15 q^2 - 10 q^4 + 3 q^6 - 8 q) / 16 instead of
//   the major strain e_1. The two quantities are equal at q = 0 and q = 1.
// - In the term h (C_1 - C_0), the contraction across the stretch is limited to three times the
//   stretch. For u = e_2 / e_1 < -1, e_2 is replaced by -e_1 (1 + 2 y / sqrt(1 + y^2)) with
//   y = (-u - 1) / 2. Without this limit, a small stretch would stiffen cloth that is compressed
//   across it.
#pragma once

#include <array>

#include "materials/jet.h"
#include "materials/types.h"

namespace weft::materials {

class MeasuredStretch {
 public:
  static constexpr int angle_count = 5, row_count = 1 + angle_count;
  // One matrix C as its entries 11, 12, 22 and 33, N/m.
  using Row = std::array<double, 4>;

  // `rows` holds C_0, then C_1 at the five angles. Precondition: in each row, no entry is negative,
  // and C_12^2 <= C_11 C_22.
  explicit MeasuredStretch(const std::array<Row, row_count>& rows);

  // Returns the energy w (N/m) at the strain (E_11, E_22, 2 E_12). `Number` may be any number type
  // (jet.h).
  template <class Number>
  Number energy(const std::array<Number, 3>& strain) const {
    const Direction<Number> at(strain);
    const std::array<Number, 4> more = stretched_row(at);
    const std::array<Number, 4> squares = squares_of(strain), limited = squares_of(at.limited);
    Number at_rest(0.0), change(0.0);
    for (int k = 0; k < 4; ++k) {
      at_rest += at_rest_[k] * squares[k];
      change += (more[k] - Number(at_rest_[k])) * limited[k];
    }
    return 0.5 * (at_rest + averaged_weight(at.magnitude) * change);
  }
  // Returns the matrix C(s, phi) that acts on (E_11, E_22, 2 E_12), N/m. Its entries are clipped to
  // make it positive semi-definite. It approximates the second derivatives of w.
  template <class Real>
  Symmetric3Of<Real> semi_definite_moduli(const std::array<Real, 3>& strain) const {
    const Direction<Real> at(strain);
    const std::array<Real, 4> more = stretched_row(at);
    const Real share = weight(at.magnitude);
    std::array<Real, 4> c;
    for (int k = 0; k < 4; ++k) c[k] = at_rest_[k] + share * (more[k] - at_rest_[k]);
    const Real warp = larger(c[0], 0.0), weft = larger(c[2], 0.0);
    const Real limit = square_root(warp * weft);
    const Real coupling = larger(-larger(-c[1], -limit), -limit);
    return {{warp, coupling, Real(0.0), weft, Real(0.0), 0.5 * larger(c[3], 0.0)}};
  }

 private:
  static constexpr double saturation = 1.0 / 6.0;  // lambda_1 - 1 at which s reaches 1
  static constexpr double smallest = 1e-8;         // strain below which directions are smoothed

  // The quantities of a strain on which w depends.
  template <class Number>
  struct Direction {
    Number magnitude;               // smoothed major Green strain, from which s is computed
    Number cosine;                  // r cos 2 phi
    Number squared_radius;          // r^2
    std::array<Number, 3> limited;  // strain (E_11, E_22, 2 E_12) with the limited contraction

    explicit Direction(const std::array<Number, 3>& strain) {
      using Real = decltype(value_of(strain[0]));
      const Number trace = strain[0] + strain[1], difference = strain[0] - strain[1];
      const Number distance =
          root(difference * difference + strain[2] * strain[2] + Number(smallest * smallest));
      const Number major = 0.5 * (trace + distance), minor = 0.5 * (trace - distance);
      const Number positive = at_least(trace, 1e-4 * smallest);
      const Number ratio = distance * inverse(positive);
      const Real q = 1.0 - larger(1.0 - value_of(ratio), 0.0), square = q * q;
      const Number deviation =
          composed(ratio, q * (q * (15.0 + square * (3.0 * square - 10.0)) - 8.0) / 16.0,
                   q * (30.0 + square * (18.0 * square - 40.0)) / 16.0 - 0.5,
                   (30.0 + square * (90.0 * square - 120.0)) / 16.0);
      magnitude = at_least(major, 0.0) + positive * deviation;
      const Number radius =
          composed(ratio, q * (15.0 + square * (3.0 * square - 10.0)) / 8.0,
                   15.0 / 8.0 * (1.0 - square) * (1.0 - square), 7.5 * q * (square - 1.0));
      cosine = radius * difference * inverse(distance);
      squared_radius = radius * radius;
      const Number stretch = at_least(major, 1e-4 * smallest);
      const Number contraction = minor * inverse(stretch);
      const Real y = larger(-0.5 * value_of(contraction) - 0.5, 0.0);
      const Real part = 1.0 / (1.0 + y * y), root_of_part = square_root(part);
      // Excess of the contraction over its limited value.
      const Number excess =
          stretch * composed(contraction, 2.0 * y * (1.0 - root_of_part), part * root_of_part - 1.0,
                             1.5 * y * part * part * root_of_part);
      const Number mean = 0.5 * (trace + excess);
      const Number half = 0.5 * (distance - excess) * inverse(distance);
      limited = {mean + half * difference, mean - half * difference, 2.0 * half * strain[2]};
    }
  };

  // Returns E_11^2, 2 E_11 E_22, E_22^2 and 2 E_12^2. Their dot product with a Row is E : C : E.
  template <class Number>
  static std::array<Number, 4> squares_of(const std::array<Number, 3>& strain) {
    return {strain[0] * strain[0], 2.0 * strain[0] * strain[1], strain[1] * strain[1],
            0.5 * strain[2] * strain[2]};
  }

  // Returns C_1 for the direction of a strain.
  template <class Number>
  std::array<Number, 4> stretched_row(const Direction<Number>& at) const {
    const Number &x = at.cosine, &p = at.squared_radius, square = x * x;
    // Entry j - 1 is r^j cos 2 j phi.
    const std::array<Number, angle_count - 1> waves{
        x, 2.0 * square - p, x * (4.0 * square - 3.0 * p), 8.0 * square * (square - p) + p * p};
    std::array<Number, 4> row;
    for (int k = 0; k < 4; ++k) {
      row[k] = Number(waves_[0][k]);
      for (int j = 1; j < angle_count; ++j) row[k] += waves_[j][k] * waves[j - 1];
    }
    return row;
  }

  // Returns s for the major Green strain `magnitude`.
  template <class Real>
  static Real weight(const Real& magnitude) {
    const Real stretch = 2.0 * magnitude / (1.0 + square_root(1.0 + 2.0 * magnitude));
    return 1.0 - larger(1.0 - stretch / saturation, 0.0);
  }
  // Returns h = 2 / m^2 int_0^m s m dm for the major Green strain m. With z = lambda_1 - 1,
  // m = z + z^2 / 2. Up to the saturation (6 z <= 1), s = 6 z and the integral is
  // 2 z^3 + 9/4 z^4 + 3/5 z^5.
  template <class Number>
  static Number averaged_weight(const Number& magnitude) {
    using Real = decltype(value_of(magnitude));
    const Real m = larger(value_of(magnitude), 1e-4 * smallest);
    const Real z = 2.0 * m / (1.0 + square_root(1.0 + 2.0 * m)), half = 1.0 + 0.5 * z;
    constexpr double full = saturation * (1 + saturation / 2);
    constexpr double rest = full * full - 2 * saturation * saturation * saturation *
                                              (2 + saturation * (2.25 + 0.6 * saturation));
    const auto below = z < Real(saturation);
    const Real h =
        choose(below, 2.0 * z * (2.0 + z * (2.25 + 0.6 * z)) / (half * half), 1.0 - rest / (m * m));
    const Real s = choose(below, z / saturation, Real(1.0));
    const Real s_slope = choose(below, 1.0 / (saturation * (1.0 + z)), Real(0.0));
    const Real slope = 2.0 * (s - h) / m;
    return composed(magnitude, h, slope, 2.0 * (s_slope - 1.5 * slope) / m);
  }

  Row at_rest_;                           // C_0
  std::array<Row, angle_count> waves_{};  // coefficients a_j
};

}  // namespace weft::materials
