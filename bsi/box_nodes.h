// Blocks of a box pyramid and the tests of their boxes. For kernel files alone, as box_lanes.h.
#pragma once

#include "bsi/box_lanes.h"
#include "bsi/box_layout.h"

namespace weft::bsi::WEFT_KERNELS {

constexpr float largest_float = 3.402823466e38F;

WEFT_INLINE const BoxLevel& level_of(const BoxTree& tree, BoxNode node) {
  return tree.levels[node.level];
}
WEFT_INLINE bool is_leaf(const BoxLevel& level) { return level.groups == nullptr; }
WEFT_INLINE std::size_t block_of(const BoxLevel& level, BoxNode node) {
  return (static_cast<std::size_t>(node.v) << level.log_u) + node.u;
}
WEFT_INLINE bool same(BoxNode a, BoxNode b) {
  return a.level == b.level && a.u == b.u && a.v == b.v;
}
WEFT_INLINE BoxNode child_of(const BoxLevel& level, BoxNode node, int child) {
  return {node.level + 1, static_cast<std::uint16_t>((node.u << level.split_u) + (child & 1)),
          static_cast<std::uint16_t>((node.v << level.split_v) + (child >> 1))};
}

// The two rows of lanes: low - h and high + h of four boxes, one after the other in both halves.
WEFT_INLINE LaneBoxes both_halves(const BoxGroup& group, float half_margin) {
  LaneBoxes boxes;
  for (int axis = 0; axis < 3; ++axis) {
    const Quad low = load_quad(group.low[axis]) - half_margin;
    const Quad high = load_quad(group.high[axis]) + half_margin;
    boxes.low[axis] = __builtin_shufflevector(low, low, 0, 1, 2, 3, 0, 1, 2, 3);
    boxes.high[axis] = __builtin_shufflevector(high, high, 0, 1, 2, 3, 0, 1, 2, 3);
  }
  return boxes;
}

// Boxes `first` and first + 1 of four, each four times over.
template <int first>
WEFT_INLINE LaneBoxes each_four_times(const LaneBoxes& boxes) {
  LaneBoxes result;
  for (int axis = 0; axis < 3; ++axis) {
    const Lanes low = boxes.low[axis], high = boxes.high[axis];
    constexpr int f = first;
    result.low[axis] = __builtin_shufflevector(low, low, f, f, f, f, f + 1, f + 1, f + 1, f + 1);
    result.high[axis] = __builtin_shufflevector(high, high, f, f, f, f, f + 1, f + 1, f + 1, f + 1);
  }
  return result;
}

// Bit 4 i + j: child i of the one overlaps child j of the other.
WEFT_INLINE unsigned overlap_of_children(const BoxGroup& a, const BoxGroup& b, float half_margin) {
#if defined(__AVX512DQ__)
  const __m512i four_times = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
  const __m128 half = _mm_set1_ps(half_margin);
  __mmask16 mask = 0xffff, other = 0xffff;  // two, for each waits for the one before
  for (int axis = 0; axis < 3; ++axis) {
    const __m512 low_a = _mm512_permutexvar_ps(
        four_times, _mm512_castps128_ps512(_mm_sub_ps(_mm_load_ps(a.low[axis]), half)));
    const __m512 high_a = _mm512_permutexvar_ps(
        four_times, _mm512_castps128_ps512(_mm_add_ps(_mm_load_ps(a.high[axis]), half)));
    const __m512 low_b = _mm512_broadcast_f32x4(_mm_sub_ps(_mm_load_ps(b.low[axis]), half));
    const __m512 high_b = _mm512_broadcast_f32x4(_mm_add_ps(_mm_load_ps(b.high[axis]), half));
    mask = _mm512_mask_cmp_ps_mask(mask, low_a, high_b, _CMP_LE_OQ);
    other = _mm512_mask_cmp_ps_mask(other, low_b, high_a, _CMP_LE_OQ);
  }
  return mask & other;
#else
  const LaneBoxes of_a = both_halves(a, half_margin);
  const LaneBoxes of_b = both_halves(b, half_margin);
  return overlap(each_four_times<0>(of_a), of_b) | overlap(each_four_times<2>(of_a), of_b) << 8;
#endif
}

struct WideBox {
  float low[3], high[3];
};

WEFT_INLINE WideBox box_of(const BoxTree& tree, BoxNode node, float half_margin) {
  WideBox box;
  const BoxLevel& level = level_of(tree, node);
  const BoxPatch& patch = tree.patches[level.patch];
  if (node.level == patch.first_level) {
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = patch.low[axis] - half_margin;
      box.high[axis] = patch.high[axis] + half_margin;
    }
    return box;
  }
  const BoxLevel& above = tree.levels[node.level - 1];
  const BoxNode parent{node.level - 1, static_cast<std::uint16_t>(node.u >> above.split_u),
                       static_cast<std::uint16_t>(node.v >> above.split_v)};
  const int child = 2 * (above.split_v * (node.v & 1)) + above.split_u * (node.u & 1);
  const BoxGroup& group = above.groups[block_of(above, parent)];
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = group.low[axis][child] - half_margin;
    box.high[axis] = group.high[axis][child] + half_margin;
  }
  return box;
}

WEFT_INLINE LaneBoxes in_all_lanes(const float low[3], const float high[3]) {
  LaneBoxes boxes;
  for (int axis = 0; axis < 3; ++axis) {
    boxes.low[axis] = broadcast(low[axis]);
    boxes.high[axis] = broadcast(high[axis]);
  }
  return boxes;
}

WEFT_INLINE unsigned overlap_of_box(const WideBox& box, const BoxGroup& group, float half_margin) {
  return overlap(in_all_lanes(box.low, box.high), both_halves(group, half_margin)) & 15U;
}

}  // namespace weft::bsi::WEFT_KERNELS
