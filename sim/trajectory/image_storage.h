// How the images of a trajectory are stored: the precision of their numbers and their compression.
// Private to sim/.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/base/hdf5_handle.h"
#include "sim/base/vectors.h"
#include "sim/case/case.h"

namespace weft::sim {

// Rounds numbers to multiples of a power of two. Their last bits become zeros, which compress well.
class Rounding {
 public:
  // Makes a rounding that changes nothing.
  Rounding() = default;
  // Rounds to multiples of the largest power of two that changes no number by more than `error` (>
  // 0).
  explicit Rounding(double error);

  // Replaces numbers by the nearest multiples, which a Number represents exactly. Numbers so large
  // that every one is a multiple stay as they are, and so do infinity and NaN.
  template <class Number>
  void apply(std::span<Number> numbers) const {
    if (quantum_ == 0) return;
    for (Number& number : numbers) {
      const double value = static_cast<double>(number);
      if (std::abs(value) < least_multiple_)
        number = static_cast<Number>(std::rint(value / quantum_) * quantum_);
    }
  }

 private:
  double quantum_ = 0;
  double least_multiple_ = 0;  // all numbers of at least this size are multiples
};

// Appends the image of a body, texel by texel. `by_particle` has `components` numbers per particle.
// O(texels).
template <class Number>
void append_texels(const bsi::Atlas& atlas, std::span<const double> by_particle, int components,
                   std::vector<Number>& texels) {
  const std::size_t before = texels.size();
  texels.resize(before + static_cast<std::size_t>(components) *
                             static_cast<std::size_t>(atlas.texel_count()));
  Number* target = texels.data() + before;
  for (int texel = 0; texel < atlas.texel_count(); ++texel) {
    const double* value = by_particle.data() +
                          static_cast<std::ptrdiff_t>(components) * atlas.particle_of_texel(texel);
    for (int k = 0; k < components; ++k) *target++ = static_cast<Number>(value[k]);
  }
}

// Appends the image of a body's positions, rounded. O(texels).
template <class Number>
void append_positions(const bsi::Atlas& atlas, std::span<const Vec3> by_particle,
                      const Rounding& rounding, std::vector<Number>& texels) {
  const std::size_t before = texels.size();
  append_texels(atlas, numbers_of(by_particle), 3, texels);
  rounding.apply(std::span(texels).subspan(before));
}

// Sets the filters of a compression for a chunked dataset: shuffle and gzip, which every HDF5
// library has.
void set_filters(hid_t properties, Compression compression);

// Returns the HDF5 type of positions in the file.
hid_t file_type(Precision precision);

}  // namespace weft::sim
