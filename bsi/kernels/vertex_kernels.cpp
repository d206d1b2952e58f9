// Loops that load the vertices of pyramids. Compiled once per instruction set: see
// bsi/detail/instruction_set.h for the restrictions.
#include "bsi/kernels/vertex_kernels.h"

#include "bsi/kernels/wide_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

// Checks whether the magnitudes of all added numbers stay below a limit. A NaN fails the check.
struct LimitCheck {
  WideBits largest{};
  void add(Wide value) {
    const WideBits bits = magnitude_bits(value);
    largest = bits > largest ? bits : largest;
  }
  bool stays_below(float limit) const {
    // The bits of magnitudes, read as integers, are ordered like the magnitudes.
    const WideBits beyond = largest >= __builtin_bit_cast(std::int32_t, limit);
    std::int32_t any = 0;
    for (int i = 0; i < width; ++i) any |= beyond[i];
    return any == 0;
  }
};

bool load(const double* positions, const std::int32_t* particle, int count, float limit,
          float* const component[3]) {
  if (particle == nullptr && count >= width) {
    LimitCheck check;
    float *const x = component[0], *const y = component[1], *const z = component[2];
    const auto load_at = [&](int i) __attribute__((always_inline)) {
      const Wide a = load_rounded(positions + 3 * i);
      const Wide b = load_rounded(positions + 3 * i + width);
      const Wide c = load_rounded(positions + 3 * i + 2 * width);
      check.add(a);
      check.add(b);
      check.add(c);
      store_wide(x + i, every_third<0>(a, b, c));
      store_wide(y + i, every_third<1>(a, b, c));
      store_wide(z + i, every_third<2>(a, b, c));
    };
    for (int i = 0; i + width <= count; i += width) load_at(i);
    // The last vector overlaps the previous one, so that it stays within the row.
    if (count % width != 0) load_at(count - width);
    return check.stays_below(limit);
  }
  bool below = true;
  for (int i = 0; i < count; ++i) {
    const double* position =
        positions + 3 * static_cast<std::ptrdiff_t>(particle == nullptr ? i : particle[i]);
    for (int axis = 0; axis < 3; ++axis) {
      component[axis][i] = static_cast<float>(position[axis]);
      below = below & (__builtin_fabsf(component[axis][i]) < limit);
    }
  }
  return below;
}

}  // namespace

extern const VertexKernels vertex_kernels;
const VertexKernels vertex_kernels = {load};

}  // namespace weft::bsi::WEFT_KERNELS
