// Leaf blocks and the boxes of their leaves. For kernel files only, like box_lanes.h.
#pragma once

#include "bsi/kernels/box_descent_kernels.h"
#include "bsi/kernels/box_nodes.h"
#include "bsi/kernels/leaf_quads.h"

namespace weft::bsi::WEFT_KERNELS {

// Bounds the quads of a leaf block, up to four, along one axis, at one end of the path. low[0] and
// high[0] bound their first triangles (or whole quads, if `triangles` is false), low[1] and high[1]
// their second triangles. With `join` the bounds include the previous bounds.
WEFT_INLINE void bound_corners(const VertexImage& image, int axis, const LeafQuads& quads,
                               bool triangles, bool join, Quad low[2], Quad high[2]) {
  const float* first = image.component[axis] + quads.row * image.stride + quads.col;
  const Quad row0 = load_quad(first);
  const Quad row1 = load_quad(first + image.stride);
  const Quad row2 = load_quad(quads.rows > 1 ? first + 2 * image.stride : first + image.stride);
  const Quad corner00 = __builtin_shufflevector(row0, row1, 0, 1, 4, 5);
  const Quad corner01 = __builtin_shufflevector(row0, row1, 1, 2, 5, 6);
  const Quad corner10 = __builtin_shufflevector(row1, row2, 0, 1, 4, 5);
  const Quad corner11 = __builtin_shufflevector(row1, row2, 1, 2, 5, 6);
  const Quad diagonal_low = smaller(corner01, corner10);
  const Quad diagonal_high = larger(corner01, corner10);
  Quad first_low = smaller(corner00, diagonal_low), second_low = smaller(corner11, diagonal_low);
  Quad first_high = larger(corner00, diagonal_high), second_high = larger(corner11, diagonal_high);
  if (!triangles) {
    first_low = smaller(first_low, second_low);
    first_high = larger(first_high, second_high);
  }
  low[0] = join ? smaller(low[0], first_low) : first_low;
  low[1] = join ? smaller(low[1], second_low) : second_low;
  high[0] = join ? larger(high[0], first_high) : first_high;
  high[1] = join ? larger(high[1], second_high) : second_high;
}

// Sets the boxes of lanes without a leaf to boxes that overlap nothing.
static void blank_absent_leaves(LaneBoxes& boxes, const LeafQuads& quads, bool triangles) {
  for (int lane = 0; lane < 8; ++lane) {
    const bool there =
        lane / 2 % 2 < quads.rows && lane % 2 < quads.cols && (triangles || lane < 4);
    if (there) continue;
    for (int axis = 0; axis < 3; ++axis) {
      boxes.low[axis][lane] = largest_float;
      boxes.high[axis][lane] = -largest_float;
    }
  }
}

// Computes the widened boxes of the leaves of a leaf block, one per lane.
static void make_leaves(const DescentQuery& query, const BoxTree& tree, BoxNode node,
                        LaneBoxes& boxes) {
  const BoxPatch& patch = tree.patches[level_of(tree, node).patch];
  const LeafQuads quads = quads_of(tree, node);
  const VertexImage* images = patch.vertices;
  LeafQuads there = quads;  // position of the quads in `images`
  PlacedVertices placed[2];
  VertexImage placed_images[2];
  if (__builtin_expect(static_cast<long>(tree.placement != nullptr), 0) != 0) {
    for (int end = 0; end <= tree.swept; ++end) {
      place_vertices(tree, patch, quads, end, placed[end]);
      placed_images[end].stride = 4;
      for (int axis = 0; axis < 3; ++axis)
        placed_images[end].component[axis] = placed[end].component[axis];
    }
    images = placed_images;
    there.row = there.col = 0;
  }
  for (int axis = 0; axis < 3; ++axis) {
    Quad low[2], high[2];
    bound_corners(images[0], axis, there, query.triangles, false, low, high);
    if (tree.swept != 0) bound_corners(images[1], axis, there, query.triangles, true, low, high);
    boxes.low[axis] =
        __builtin_shufflevector(low[0], low[1], 0, 1, 2, 3, 4, 5, 6, 7) - query.half_margin;
    boxes.high[axis] =
        __builtin_shufflevector(high[0], high[1], 0, 1, 2, 3, 4, 5, 6, 7) + query.half_margin;
  }
  if (!query.triangles || quads.rows < 2 || quads.cols < 2)
    blank_absent_leaves(boxes, quads, query.triangles);
}

// A set of pairs of lanes of two leaf blocks. Bit 8 i + j stands for lane i of the first block and
// lane j of the second block.
typedef std::uint64_t LanePairs;

// Returns the pairs of lanes whose boxes overlap.
WEFT_INLINE LanePairs overlap_of_leaves(const LaneBoxes& a, const LaneBoxes& b) {
  LanePairs near = 0;
#if defined(__AVX512DQ__)
  __m512 low_a[3], high_a[3], low_b[3], high_b[3];
  for (int axis = 0; axis < 3; ++axis) {
    low_a[axis] = _mm512_castps256_ps512(a.low[axis]);
    high_a[axis] = _mm512_castps256_ps512(a.high[axis]);
    low_b[axis] = _mm512_broadcast_f32x8(b.low[axis]);
    high_b[axis] = _mm512_broadcast_f32x8(b.high[axis]);
  }
  // Two lanes of `a` at a time are compared with all lanes of `b`.
  __m512i lanes = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1);
  for (int i = 0; i < 8; i += 2) {
    __mmask16 mask = 0xffff;
    for (int axis = 0; axis < 3; ++axis) {
      mask = _mm512_mask_cmp_ps_mask(mask, _mm512_permutexvar_ps(lanes, low_a[axis]), high_b[axis],
                                     _CMP_LE_OQ);
      mask = _mm512_mask_cmp_ps_mask(mask, low_b[axis], _mm512_permutexvar_ps(lanes, high_a[axis]),
                                     _CMP_LE_OQ);
    }
    near |= static_cast<LanePairs>(mask) << (8 * i);
    lanes = _mm512_add_epi32(lanes, _mm512_set1_epi32(2));
  }
#elif defined(__AVX__)
  // Every lane of `a` is compared with all lanes of `b`. A test that skips lanes far from the whole
  // block `b` would cost more than it saves.
  const auto all_of = [](const float& value) { return _mm256_broadcast_ss(&value); };
#pragma GCC unroll 8
  for (int i = 0; i < 8; ++i) {
    __m256 meets[3];
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis) {
      const float* low = reinterpret_cast<const float*>(&a.low[axis]) + i;
      const float* high = reinterpret_cast<const float*>(&a.high[axis]) + i;
      meets[axis] = _mm256_and_ps(_mm256_cmp_ps(all_of(*low), b.high[axis], _CMP_LE_OQ),
                                  _mm256_cmp_ps(b.low[axis], all_of(*high), _CMP_LE_OQ));
    }
    const __m256 all = _mm256_and_ps(_mm256_and_ps(meets[0], meets[1]), meets[2]);
    near |= static_cast<LanePairs>(_mm256_movemask_ps(all)) << (8 * i);
  }
#else
  // Lanes of `a` that do not overlap the whole block `b` are skipped.
  float whole_low[3], whole_high[3];
  for (int axis = 0; axis < 3; ++axis) {
    whole_low[axis] = b.low[axis][0];
    whole_high[axis] = b.high[axis][0];
    for (int j = 1; j < 8; ++j) {
      const float low = b.low[axis][j], high = b.high[axis][j];
      whole_low[axis] = low < whole_low[axis] ? low : whole_low[axis];
      whole_high[axis] = high > whole_high[axis] ? high : whole_high[axis];
    }
  }
  unsigned near_a = overlap(a, in_all_lanes(whole_low, whole_high));
  for (; near_a != 0; near_a &= near_a - 1) {
    const int i = __builtin_ctz(near_a);
    const float low[3] = {a.low[0][i], a.low[1][i], a.low[2][i]};
    const float high[3] = {a.high[0][i], a.high[1][i], a.high[2][i]};
    near |= static_cast<LanePairs>(overlap(in_all_lanes(low, high), b)) << (8 * i);
  }
#endif
  return near;
}

}  // namespace weft::bsi::WEFT_KERNELS
