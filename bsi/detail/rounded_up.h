// Rounding of bounds from float64 to float32.
#pragma once

#include <cmath>
#include <limits>

namespace weft::bsi {

// Returns the smallest float32 number that is at least `value`.
inline float rounded_up(double value) {
  const auto rounded = static_cast<float>(value);
  if (static_cast<double>(rounded) >= value) return rounded;
  return std::nextafter(rounded, std::numeric_limits<float>::infinity());
}

}  // namespace weft::bsi
