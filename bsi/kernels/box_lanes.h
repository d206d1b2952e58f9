// Vectors of eight floats, and boxes and spheres in their lanes. For kernel files only. Every
// function is forced inline into the namespace of its kernels. No two instruction sets then share a
// function (see bsi/detail/instruction_set.h).
#pragma once

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include "bsi/detail/sphere_bounds.h"

#define WEFT_INLINE static inline __attribute__((always_inline))

namespace weft::bsi::WEFT_KERNELS {

typedef float Lanes __attribute__((vector_size(32)));
typedef float UnalignedLanes __attribute__((vector_size(32), aligned(4), may_alias));
typedef float Quad __attribute__((vector_size(16)));
typedef float UnalignedQuad __attribute__((vector_size(16), aligned(4), may_alias));

WEFT_INLINE Lanes load(const float* from) { return *reinterpret_cast<const UnalignedLanes*>(from); }
WEFT_INLINE Quad load_quad(const float* from) {
  return *reinterpret_cast<const UnalignedQuad*>(from);
}
WEFT_INLINE void store(float* to, Lanes lanes) { *reinterpret_cast<UnalignedLanes*>(to) = lanes; }
WEFT_INLINE Lanes broadcast(float value) {
  return Lanes{value, value, value, value, value, value, value, value};
}

WEFT_INLINE float larger(float a, float b) { return a > b ? a : b; }
WEFT_INLINE double larger(double a, double b) { return a > b ? a : b; }

WEFT_INLINE Quad smaller(Quad a, Quad b) {
#if defined(__AVX__)
  return _mm_min_ps(a, b);
#else
  return a < b ? a : b;
#endif
}

WEFT_INLINE Quad larger(Quad a, Quad b) {
#if defined(__AVX__)
  return _mm_max_ps(a, b);
#else
  return a > b ? a : b;
#endif
}

// Eight boxes, one per lane, with a vector for each bound and axis.
struct LaneBoxes {
  Lanes low[3], high[3];
};

// Returns a mask. Bit i is set if the closed boxes in lane i of `a` and of `b` overlap.
WEFT_INLINE unsigned overlap(const LaneBoxes& a, const LaneBoxes& b) {
#if defined(__AVX512VL__)
  __mmask8 mask = _mm256_cmp_ps_mask(a.low[0], b.high[0], _CMP_LE_OQ);
  mask = _mm256_mask_cmp_ps_mask(mask, b.low[0], a.high[0], _CMP_LE_OQ);
  mask = _mm256_mask_cmp_ps_mask(mask, a.low[1], b.high[1], _CMP_LE_OQ);
  mask = _mm256_mask_cmp_ps_mask(mask, b.low[1], a.high[1], _CMP_LE_OQ);
  mask = _mm256_mask_cmp_ps_mask(mask, a.low[2], b.high[2], _CMP_LE_OQ);
  return _mm256_mask_cmp_ps_mask(mask, b.low[2], a.high[2], _CMP_LE_OQ);
#else
  const auto meets = (a.low[0] <= b.high[0]) & (b.low[0] <= a.high[0]) & (a.low[1] <= b.high[1]) &
                     (b.low[1] <= a.high[1]) & (a.low[2] <= b.high[2]) & (b.low[2] <= a.high[2]);
#if defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(meets)));
#else
  unsigned mask = 0;
  for (int i = 0; i < 8; ++i) mask |= meets[i] != 0 ? 1U << i : 0U;
  return mask;
#endif
#endif
}

// Eight spheres, one per lane, with a vector for each component.
struct LaneSpheres {
  Lanes centre[3], radius;
};

// Returns a mask. Bit i is set if the spheres in lane i of `a` and of `b` touch. It is clear if a
// centre is NaN.
WEFT_INLINE unsigned touch(const LaneSpheres& a, const LaneSpheres& b) {
  const Lanes x = a.centre[0] - b.centre[0], y = a.centre[1] - b.centre[1],
              z = a.centre[2] - b.centre[2];
  const Lanes reach = (a.radius + b.radius) * touch_factor;
  const auto touches = x * x + y * y + z * z <= reach * reach;
#if defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(touches)));
#else
  unsigned mask = 0;
  for (int i = 0; i < 8; ++i) mask |= touches[i] != 0 ? 1U << i : 0U;
  return mask;
#endif
}

}  // namespace weft::bsi::WEFT_KERNELS
