// Blocks of a pyramid, and the tests of their boxes and spheres. For kernel files only, like
// box_lanes.h.
#pragma once

#include "bsi/detail/box_layout.h"
#include "bsi/kernels/box_lanes.h"
#include "bsi/kernels/placed_boxes.h"

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

// Returns the parent of a block. `above` is the level of the parent.
WEFT_INLINE BoxNode parent_of(const BoxLevel& above, BoxNode node) {
  return {node.level - 1, static_cast<std::uint16_t>(node.u >> above.split_u),
          static_cast<std::uint16_t>(node.v >> above.split_v)};
}
WEFT_INLINE int child_number(const BoxLevel& above, BoxNode node) {
  return 2 * (above.split_v * (node.v & 1)) + above.split_u * (node.u & 1);
}

// Returns the numbers in `four`, in lanes 0 to 3 and again in lanes 4 to 7.
WEFT_INLINE Lanes in_both_halves(Quad four) {
  return __builtin_shufflevector(four, four, 0, 1, 2, 3, 0, 1, 2, 3);
}

// Returns lane `first` of `lanes` in lanes 0 to 3, and lane `first` + 1 in lanes 4 to 7.
template <int first>
WEFT_INLINE Lanes each_four_times(Lanes lanes) {
  constexpr int f = first;
  return __builtin_shufflevector(lanes, lanes, f, f, f, f, f + 1, f + 1, f + 1, f + 1);
}

// Returns the four boxes of a group, widened by `half_margin`, in lanes 0 to 3 and again in lanes 4
// to 7.
WEFT_INLINE LaneBoxes both_halves(const BoxGroup& group, float half_margin) {
  LaneBoxes boxes;
  for (int axis = 0; axis < 3; ++axis) {
    boxes.low[axis] = in_both_halves(load_quad(group.low[axis]) - half_margin);
    boxes.high[axis] = in_both_halves(load_quad(group.high[axis]) + half_margin);
  }
  return boxes;
}

// Returns box `first` of `boxes` in lanes 0 to 3, and box `first` + 1 in lanes 4 to 7.
template <int first>
WEFT_INLINE LaneBoxes each_four_times(const LaneBoxes& boxes) {
  LaneBoxes result;
  for (int axis = 0; axis < 3; ++axis) {
    result.low[axis] = each_four_times<first>(boxes.low[axis]);
    result.high[axis] = each_four_times<first>(boxes.high[axis]);
  }
  return result;
}

// Returns a mask. Bit 4 i + j is set if child i of `a` overlaps child j of `b` when both boxes are
// widened by `half_margin`.
WEFT_INLINE unsigned overlap_of_children(const BoxGroup& a, const BoxGroup& b, float half_margin) {
#if defined(__AVX512DQ__)
  const __m512i four_times = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
  const __m128 half = _mm_set1_ps(half_margin);
  __mmask16 mask = 0xffff, other = 0xffff;  // two masks shorten the chains of dependent operations
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

// --- Spheres ---

// Returns the four spheres of a group, with radii increased by `reach`, in lanes 0 to 3 and again
// in lanes 4 to 7.
WEFT_INLINE LaneSpheres both_halves(const SphereGroup& group, float reach) {
  LaneSpheres spheres;
  for (int axis = 0; axis < 3; ++axis) {
    spheres.centre[axis] = in_both_halves(load_quad(group.centre[axis]));
  }
  spheres.radius = in_both_halves(load_quad(group.radius) + reach);
  return spheres;
}

template <int first>
WEFT_INLINE LaneSpheres each_four_times(const LaneSpheres& spheres) {
  LaneSpheres result;
  for (int axis = 0; axis < 3; ++axis) {
    result.centre[axis] = each_four_times<first>(spheres.centre[axis]);
  }
  result.radius = each_four_times<first>(spheres.radius);
  return result;
}

// Returns a mask. Bit 4 i + j is set if the spheres of child i of `a` and child j of `b` are within
// `reach` (m) of each other.
WEFT_INLINE unsigned touch_of_children(const SphereGroup& a, const SphereGroup& b, float reach) {
#if defined(__AVX512DQ__)
  const __m512i four_times = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
  const auto of_a = [&](__m128 four) {
    return _mm512_permutexvar_ps(four_times, _mm512_castps128_ps512(four));
  };
  __m512 squared = _mm512_setzero_ps();
  for (int axis = 0; axis < 3; ++axis) {
    const __m512 apart = _mm512_sub_ps(of_a(_mm_load_ps(a.centre[axis])),
                                       _mm512_broadcast_f32x4(_mm_load_ps(b.centre[axis])));
    squared = _mm512_add_ps(squared, _mm512_mul_ps(apart, apart));
  }
  const __m128 radius_b = _mm_add_ps(_mm_load_ps(b.radius), _mm_set1_ps(reach));
  const __m512 radii =
      _mm512_mul_ps(_mm512_add_ps(of_a(_mm_load_ps(a.radius)), _mm512_broadcast_f32x4(radius_b)),
                    _mm512_set1_ps(touch_factor));
  return _mm512_cmp_ps_mask(squared, _mm512_mul_ps(radii, radii), _CMP_LE_OQ);
#else
  const LaneSpheres of_a = both_halves(a, 0), of_b = both_halves(b, reach);
  return touch(each_four_times<0>(of_a), of_b) | touch(each_four_times<2>(of_a), of_b) << 8;
#endif
}

// Returns the sphere of a block in all lanes.
WEFT_INLINE LaneSpheres sphere_of(const BoxTree& tree, BoxNode node) {
  const BoxLevel& level = level_of(tree, node);
  const BoxPatch& patch = tree.patches[level.patch];
  float sphere[4];
  if (node.level == patch.first_level) {
    SphereGroup own{}, room;
    for (int axis = 0; axis < 3; ++axis) own.centre[axis][0] = patch.centre[axis];
    own.radius[0] = patch.radius;
    const SphereGroup& group = in_space(tree, own, room);
    for (int axis = 0; axis < 3; ++axis) sphere[axis] = group.centre[axis][0];
    sphere[3] = group.radius[0];
  } else {
    const BoxLevel& above = tree.levels[node.level - 1];
    const BoxNode parent = parent_of(above, node);
    SphereGroup room;
    const SphereGroup& group = in_space(tree, above.spheres[block_of(above, parent)], room);
    const int child = child_number(above, node);
    for (int axis = 0; axis < 3; ++axis) sphere[axis] = group.centre[axis][child];
    sphere[3] = group.radius[child];
  }
  return {{broadcast(sphere[0]), broadcast(sphere[1]), broadcast(sphere[2])}, broadcast(sphere[3])};
}

// Returns a mask. Bit j is set if `sphere` and the sphere of child j are within `reach` (m) of each
// other.
WEFT_INLINE unsigned touch_of_sphere(const LaneSpheres& sphere, const SphereGroup& group,
                                     float reach) {
  return touch(sphere, both_halves(group, reach)) & 15U;
}

// --- Boxes of single blocks ---

struct WideBox {
  float low[3], high[3];
};

WEFT_INLINE WideBox box_of(const BoxTree& tree, BoxNode node, float half_margin) {
  WideBox box;
  const BoxLevel& level = level_of(tree, node);
  const BoxPatch& patch = tree.patches[level.patch];
  BoxGroup room;
  if (node.level == patch.first_level) {
    BoxGroup own{};
    for (int axis = 0; axis < 3; ++axis) {
      own.low[axis][0] = patch.low[axis];
      own.high[axis][0] = patch.high[axis];
    }
    const BoxGroup& whole = in_space(tree, own, room);
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = whole.low[axis][0] - half_margin;
      box.high[axis] = whole.high[axis][0] + half_margin;
    }
    return box;
  }
  const BoxLevel& above = tree.levels[node.level - 1];
  const BoxGroup& group =
      in_space(tree, above.groups[block_of(above, parent_of(above, node))], room);
  const int child = child_number(above, node);
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
