#include "sim/trajectory/image_storage.h"

#include <cassert>
#include <limits>

namespace weft::sim {

// gzip level of compressed images (docs/decisions/0034-storage-of-trajectories.md).
constexpr unsigned gzip_level = 1;

Rounding::Rounding(double error) {
  assert(error > 0);
  int exponent = 0;
  std::frexp(error, &exponent);  // 2^(exponent - 1) <= error < 2^exponent
  // Rounding changes a number by at most half a quantum, which is 2^(exponent - 1).
  quantum_ = std::ldexp(1.0, exponent);
  least_multiple_ = std::ldexp(quantum_, std::numeric_limits<double>::digits);
}

void set_filters(hid_t properties, Compression compression) {
  if (compression == Compression::none) return;
  H5Pset_shuffle(properties);
  H5Pset_deflate(properties, gzip_level);
}

hid_t file_type(Precision precision) {
  return precision == Precision::float64 ? H5T_IEEE_F64LE : H5T_IEEE_F32LE;
}

}  // namespace weft::sim
