// Conversion of lane masks to leaf pairs. For kernel files only, like box_lanes.h.
#pragma once

#include "bsi/kernels/box_lanes.h"
#include "bsi/leaf_pair.h"

namespace weft::bsi::WEFT_KERNELS {

// Writes the pair (a, b[j]) for every set bit j of the mask, with the smaller index first if
// `sorted`. Returns the number of pairs. May write eight pairs, however many bits are set.
WEFT_INLINE int store_pairs(LeafPair* to, unsigned mask, int a, const int b[8], bool sorted) {
#if defined(__AVX512VL__)
  const __m256i of_b = _mm256_load_si256(reinterpret_cast<const __m256i*>(b));
  const __m256i of_a = _mm256_set1_epi32(a);
  const __m256i first = sorted ? _mm256_min_epi32(of_a, of_b) : of_a;
  const __m256i second = sorted ? _mm256_max_epi32(of_a, of_b) : of_b;
  const __m512i pairs = _mm512_or_si512(_mm512_cvtepu32_epi64(first),
                                        _mm512_slli_epi64(_mm512_cvtepu32_epi64(second), 32));
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi64(static_cast<__mmask8>(mask), pairs));
  return __builtin_popcount(mask);
#else
  int count = 0;
  for (; mask != 0; mask &= mask - 1) {
    const int j = __builtin_ctz(mask);
    const bool swap = sorted && a > b[j];
    to[count++] = swap ? LeafPair{b[j], a} : LeafPair{a, b[j]};
  }
  return count;
#endif
}

}  // namespace weft::bsi::WEFT_KERNELS
