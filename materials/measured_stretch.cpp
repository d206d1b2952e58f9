#include "materials/measured_stretch.h"

#include <cmath>
#include <numbers>

namespace weft::materials {

// Computes the coefficients a_j by a discrete cosine transform of the values of C_1.
MeasuredStretch::MeasuredStretch(const std::array<Row, row_count>& rows) : at_rest_(rows[0]) {
  constexpr int last = angle_count - 1;
  for (int j = 0; j < angle_count; ++j) {
    for (int i = 0; i < angle_count; ++i) {
      const double share = (i == 0 || i == last ? 0.5 : 1.0) * (j == 0 || j == last ? 1.0 : 2.0);
      const double wave = share / last * std::cos(std::numbers::pi * i * j / last);
      for (int k = 0; k < 4; ++k) waves_[j][k] += wave * rows[1 + i][k];
    }
  }
}

}  // namespace weft::materials
