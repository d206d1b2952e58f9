// Storage of the images of a trajectory: precision of their numbers, rounding and compression.
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

// A rounding of numbers to multiples of a power of two. The last bits of rounded numbers are zeros,
// which compress well.
class Rounding {
 public:
  // Makes a rounding that changes nothing.
  Rounding() = default;
  // Makes a rounding to multiples of the largest power of two for which no number changes by more
  // than `error`. Precondition: error > 0.
  explicit Rounding(double error);

  // Rounds numbers in place to the nearest multiples, which the type Number represents exactly.
  // Infinity, NaN and numbers so large that they are multiples already do not change.
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
  double least_multiple_ = 0;  // every double of at least this magnitude is a multiple of quantum_
};

// Appends an image of a body to `texels`, texel by texel. `by_particle` holds the values:
// `components` numbers per particle. O(texels).
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

// Appends the rounded image of a body's positions to `texels`. `by_particle` holds the positions
// (m). O(texels).
template <class Number>
void append_positions(const bsi::Atlas& atlas, std::span<const Vec3> by_particle,
                      const Rounding& rounding, std::vector<Number>& texels) {
  const std::size_t before = texels.size();
  append_texels(atlas, numbers_of(by_particle), 3, texels);
  rounding.apply(std::span(texels).subspan(before));
}

// Sets the HDF5 filters for a compression in the creation properties of a chunked dataset: shuffle
// and gzip, or no filter.
void set_filters(hid_t properties, Compression compression);

// Returns the HDF5 type in which files store positions of this precision.
hid_t file_type(Precision precision);

}  // namespace weft::sim
