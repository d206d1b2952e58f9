#include "materials/orthotropic_moduli.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace weft::materials {

Mat3 OrthotropicModuli::matrix() const {
  Mat3 matrix;
  matrix << warp, coupling, 0, coupling, weft, 0, 0, 0, shear;
  return matrix;
}

OrthotropicModuli orthotropic_moduli(double warp, double weft, double shear, double poisson_ratio) {
  if (poisson_ratio == 0) return {warp, 0, weft, shear};
  // The compliance is symmetric, so Poisson's ratio for a pull along the weft is
  // poisson_ratio weft / warp.
  const double contraction = 1 - poisson_ratio * (poisson_ratio * weft / warp);
  assert(contraction > 0);
  return {warp / contraction, poisson_ratio * weft / contraction, weft / contraction, shear};
}

double least_bias(double warp, double weft) {
  const double difference = std::sqrt(warp) - std::sqrt(weft);
  return 0.25 * difference * difference;
}

bool is_bending_possible(double warp, double bias, double weft) {
  return warp > 0 && weft > 0 && bias > least_bias(warp, weft);
}

OrthotropicModuli bending_moduli(double warp, double bias, double weft, double poisson_ratio) {
  assert(poisson_ratio > -1 && poisson_ratio < 1 && is_bending_possible(warp, bias, weft));
  const double twist = 2 * bias - 0.5 * (warp + weft);
  const double coupling =
      twist < 0 ? twist : poisson_ratio * std::min(twist, std::sqrt(warp * weft));
  return {warp, coupling, weft, 0.5 * (twist - coupling)};
}

}  // namespace weft::materials
