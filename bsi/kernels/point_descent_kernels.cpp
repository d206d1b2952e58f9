// The loop that descends a box pyramid with points. Compiled once per instruction set: see
// bsi/detail/instruction_set.h for the restrictions.
#include "bsi/kernels/point_descent_kernels.h"

#include "bsi/kernels/leaf_blocks.h"
#include "bsi/kernels/store_pairs.h"
#include "bsi/kernels/wide_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

// Lists of points in the workspace: coordinates by component, and indices. Points are copied from
// level to level, so that each list is contiguous.
struct PointLists {
  float* value[3];
  std::int32_t* number;
  float* half;  // half margin of every point, by index, m
};

WEFT_INLINE PointLists lists_in(void* workspace) {
  auto* numbers = static_cast<std::int32_t*>(workspace);
  auto* floats = reinterpret_cast<float*>(numbers + point_list_length);
  return {{floats, floats + point_list_length, floats + 2 * point_list_length},
          numbers,
          floats + 3 * point_list_length};
}

// --- Loading ---

// Vectors with half as many lanes as Wide: width / 2 doubles, floats or integers.
typedef double Doubles __attribute__((vector_size(4 * width)));
typedef double UnalignedDoubles __attribute__((vector_size(4 * width), aligned(8), may_alias));
typedef float Half __attribute__((vector_size(2 * width)));
typedef std::int32_t HalfBits __attribute__((vector_size(2 * width)));

template <int... i>
WEFT_INLINE Wide joined(Half first, Half second, Indices<i...>) {
  return __builtin_shufflevector(first, second, i...);
}
WEFT_INLINE Wide joined(Half first, Half second) {
  return joined(first, second, IndicesUpTo<width>::Type{});
}

// Returns the smallest float32 numbers that are at least `values`. Precondition: no value is
// negative.
WEFT_INLINE Half rounded_up(Doubles values) {
  const Half nearest = __builtin_convertvector(values, Half);
  const auto less = __builtin_convertvector(nearest, Doubles) < values;  // -1 in lanes rounded down
  return reinterpret_cast<Half>(reinterpret_cast<HalfBits>(nearest) -
                                __builtin_convertvector(less, HalfBits));
}

// Rounds `width` coordinates to the nearest float32 numbers, and their magnitudes upwards.
WEFT_INLINE void round_components(const double* from, Wide& nearest, Wide& up) {
  const Doubles first = *reinterpret_cast<const UnalignedDoubles*>(from);
  const Doubles second = *reinterpret_cast<const UnalignedDoubles*>(from + width / 2);
  nearest = joined(__builtin_convertvector(first, Half), __builtin_convertvector(second, Half));
  up = joined(rounded_up(first < 0 ? -first : first), rounded_up(second < 0 ? -second : second));
}

// Returns half_margin() of each point, given its largest |coordinate|.
WEFT_INLINE Wide half_margins(double reach, float magnitude, const float (&largest)[width]) {
  const auto half_of = [&](const float* from) {
    typedef float UnalignedHalf __attribute__((vector_size(2 * width), aligned(4), may_alias));
    const Half values = *reinterpret_cast<const UnalignedHalf*>(from);
    const Doubles sum = static_cast<double>(magnitude) + __builtin_convertvector(values, Doubles);
    return rounded_up(0.5 * (reach + (0x1p-23 * sum + 0x1p-124)));
  };
  return joined(half_of(largest), half_of(largest + width / 2));
}

float load_points(const double* positions, int count, double reach, float magnitude_of_body,
                  void* workspace) {
  const PointLists lists = lists_in(workspace);
  Wide largest_half{};
  for (int i = 0; i < count; i += width) {
    const double* from = positions + 3 * static_cast<std::ptrdiff_t>(i);
    double last[3 * width] = {};
    if (count - i < width) {
      __builtin_memcpy(last, from, 3 * static_cast<std::size_t>(count - i) * sizeof(double));
      from = last;
    }
    Wide part[3], up[3];
    for (int k = 0; k < 3; ++k) round_components(from + k * width, part[k], up[k]);
    store_wide(lists.value[0] + i, every_third<0>(part[0], part[1], part[2]));
    store_wide(lists.value[1] + i, every_third<1>(part[0], part[1], part[2]));
    store_wide(lists.value[2] + i, every_third<2>(part[0], part[1], part[2]));
    alignas(64) float largest[width];
    store_wide(largest, larger(larger(every_third<0>(up[0], up[1], up[2]),
                                      every_third<1>(up[0], up[1], up[2])),
                               every_third<2>(up[0], up[1], up[2])));
    const Wide half = half_margins(reach, magnitude_of_body, largest);
    store_wide(lists.half + i, half);
    largest_half = larger(largest_half, half);
    for (int k = 0; k < width; ++k) lists.number[i + k] = i + k;
  }
  float result = 0;
  for (int k = 0; k < width; ++k) result = larger(result, static_cast<float>(largest_half[k]));
  return result;
}

// --- The descent ---

// The points near a block: `count` consecutive entries of PointLists, beginning with entry `first`.
struct PointList {
  BoxNode node;
  std::int32_t first, count;
};

// Copies entry from + i for every set bit i of the mask to consecutive entries, beginning with
// entry `to`. Returns the number of copies. May write a whole vector.
WEFT_INLINE int copy_marked(const PointLists& lists, int from, unsigned mask, int to) {
#if defined(__AVX512F__)
  const auto marked = static_cast<__mmask16>(mask);
  for (float* part : lists.value) {
    _mm512_storeu_ps(part + to, _mm512_maskz_compress_ps(marked, _mm512_loadu_ps(part + from)));
  }
  _mm512_storeu_si512(lists.number + to,
                      _mm512_maskz_compress_epi32(marked, _mm512_loadu_si512(lists.number + from)));
  return __builtin_popcount(mask);
#else
  int count = 0;
  for (; mask != 0; mask &= mask - 1) {
    const int at = from + __builtin_ctz(mask), place = to + count++;
    for (float* part : lists.value) part[place] = part[at];
    lists.number[place] = lists.number[at];
  }
  return count;
#endif
}

// Returns a mask. Bit i is set if point i lies in box `lane` of `boxes`.
WEFT_INLINE unsigned points_in(const LaneBoxes& boxes, int lane, const Wide (&point)[3]) {
#if defined(__AVX512F__)
  __mmask16 mask = 0xffff;
  for (int axis = 0; axis < 3; ++axis) {
    mask = _mm512_mask_cmp_ps_mask(mask, _mm512_set1_ps(boxes.low[axis][lane]), point[axis],
                                   _CMP_LE_OQ);
    mask = _mm512_mask_cmp_ps_mask(mask, point[axis], _mm512_set1_ps(boxes.high[axis][lane]),
                                   _CMP_LE_OQ);
  }
  return mask;
#else
  WideBits in = WideBits{} - 1;
  for (int axis = 0; axis < 3; ++axis) {
    in &= (boxes.low[axis][lane] <= point[axis]) & (point[axis] <= boxes.high[axis][lane]);
  }
  unsigned mask = 0;
  for (int k = 0; k < width; ++k) mask |= in[k] != 0 ? 1U << k : 0U;
  return mask;
#endif
}

// Returns a mask. Bit i is set if point i lies in sphere `lane` of `spheres`, with the same
// allowance for rounding as in touch().
WEFT_INLINE unsigned points_in(const LaneSpheres& spheres, int lane, const Wide (&point)[3]) {
  const Wide x = point[0] - spheres.centre[0][lane], y = point[1] - spheres.centre[1][lane],
             z = point[2] - spheres.centre[2][lane];
  const float reach = spheres.radius[lane] * touch_factor;
#if defined(__AVX512F__)
  return _mm512_cmp_ps_mask(square(x, y, z), _mm512_set1_ps(reach * reach), _CMP_LE_OQ);
#else
  const WideBits in = square(x, y, z) <= reach * reach;
  unsigned mask = 0;
  for (int k = 0; k < width; ++k) mask |= in[k] != 0 ? 1U << k : 0U;
  return mask;
#endif
}

// The point lists of the four children of a block, stored one after another behind the block's own
// list. Each has a capacity of `room` points, one vector more than the block's points.
struct ChildLists {
  std::int32_t first, room, counts[4];
  int end(int child) const { return first + child * room + counts[child]; }
};

// The bounds of a block's four children, widened by the reach of the points. `bound` selects which
// of them are compared.
struct ChildBounds {
  Bound bound;
  LaneBoxes boxes;
  LaneSpheres spheres;
};

WEFT_INLINE ChildBounds bounds_of(const DescentQuery& query, const BoxLevel& level,
                                  std::size_t block, float reach) {
  ChildBounds bounds{query.bound, both_halves(level.groups[block], reach), {}};
  if (query.bound != Bound::box) {
    bounds.spheres = both_halves(level.spheres[block], query.sphere_reach);
  }
  return bounds;
}

WEFT_INLINE unsigned points_near(const ChildBounds& bounds, int child, const Wide (&point)[3]) {
  if (bounds.bound == Bound::box) return points_in(bounds.boxes, child, point);
  const unsigned near = points_in(bounds.spheres, child, point);
  if (bounds.bound == Bound::sphere || near == 0) return near;
  return near & points_in(bounds.boxes, child, point);
}

// Distributes the points to the children by comparing a vector of points with one child at a time.
// This is faster if there are many points.
WEFT_INLINE void share_vectors(const ChildBounds& bounds, const PointLists& lists,
                               const PointList& list, ChildLists& children) {
  for (int i = 0; i < list.count; i += width) {
    const int from = list.first + i;
    const Wide point[3] = {load_wide(lists.value[0] + from), load_wide(lists.value[1] + from),
                           load_wide(lists.value[2] + from)};
    const unsigned there =
        list.count - i < width ? (1U << (list.count - i)) - 1 : (1U << (width - 1)) * 2 - 1;
    for (int child = 0; child < 4; ++child) {
      const unsigned near = points_near(bounds, child, point) & there;
      if (near == 0) continue;
      children.counts[child] += copy_marked(lists, from, near, children.end(child));
    }
  }
}

WEFT_INLINE unsigned children_near(const ChildBounds& bounds, const float (&point)[3]) {
  const LaneSpheres sphere{{broadcast(point[0]), broadcast(point[1]), broadcast(point[2])},
                           broadcast(0)};
  unsigned near = 15U;
  if (bounds.bound != Bound::box) near &= touch(bounds.spheres, sphere);
  if (bounds.bound != Bound::sphere) near &= overlap(bounds.boxes, in_all_lanes(point, point));
  return near;
}

// Distributes the points to the children by comparing one point with all children at a time. This
// is faster if there are few points.
WEFT_INLINE void share_one_by_one(const ChildBounds& bounds, const PointLists& lists,
                                  const PointList& list, ChildLists& children) {
  for (int i = list.first; i < list.first + list.count; ++i) {
    const float point[3] = {lists.value[0][i], lists.value[1][i], lists.value[2][i]};
    for (unsigned near = children_near(bounds, point); near != 0; near &= near - 1) {
      const int child = __builtin_ctz(near), place = children.end(child);
      for (float* part : lists.value) part[place] = part[i];
      lists.number[place] = lists.number[i];
      ++children.counts[child];
    }
  }
}

// Distributes the points of `list` to the children whose bounds contain them. Stores the nonempty
// lists in `next` and returns their number.
int share_points(const ChildBounds& bounds, const BoxLevel& level, const PointLists& lists,
                 const PointList& list, PointList* next) {
  ChildLists children{list.first + list.count + width, list.count + width, {}};
  constexpr int few = 4;
  if (list.count <= few) {
    share_one_by_one(bounds, lists, list, children);
  } else {
    share_vectors(bounds, lists, list, children);
  }
  int shared = 0;
  for (int child = 0; child < 4; ++child) {
    const int count = children.counts[child];
    if (count == 0) continue;
    next[shared++] = {child_of(level, list.node, child), children.end(child) - count, count};
  }
  return shared;
}

void pair_points(const DescentQuery& query, const PointLists& lists, const PointList& list,
                 int first_number, PairSink& sink) {
  LaneBoxes leaves;
  make_leaves(query, *query.a, list.node, leaves);
  alignas(32) int number[8];
  number_leaves(*query.a, list.node, query.triangles, number);
  for (int i = list.first; i < list.first + list.count; ++i) {
    const float half = lists.half[lists.number[i]];
    const float at[3] = {lists.value[0][i], lists.value[1][i], lists.value[2][i]};
    LaneBoxes boxes = leaves, box;
    for (int axis = 0; axis < 3; ++axis) {
      boxes.low[axis] -= half;
      boxes.high[axis] += half;
      box.low[axis] = broadcast(at[axis] - half);
      box.high[axis] = broadcast(at[axis] + half);
    }
    if (sink.count + pairs_per_flush > sink.capacity) sink.flush(sink);
    sink.count += store_pairs(sink.pairs + sink.count, overlap(boxes, box),
                              first_number + lists.number[i], number, false);
  }
}

void descend_points(const DescentQuery& asked, int patch, int count, float largest_half,
                    int first_number, void* workspace, PairSink& sink, DescentCounters& counters) {
  DescentQuery query = asked;
  const BoxTree& tree = *query.a;
  const PointLists lists = lists_in(workspace);
  // Above the leaves, points are compared with boxes that are widened by the margins of both sides
  // and by all rounding (docs/theory.md, "Points"). A box that is too large costs only time.
  const float reach = 2 * largest_half + 0x1p-21F * (tree.magnitude + 2 * largest_half);
  query.sphere_reach = root_of_three * reach;
  PointList stack[4 * 18];
  stack[0] = {{tree.patches[patch].first_level, 0, 0}, 0, count};
  for (int lists_left = 1; lists_left > 0;) {
    const PointList list = stack[--lists_left];
    const BoxLevel& level = level_of(tree, list.node);
    if (is_leaf(level)) {
      counters.bound_tests += 8 * list.count;
      pair_points(query, lists, list, first_number, sink);
    } else {
      counters.bound_tests += 4 * list.count;
      const ChildBounds bounds = bounds_of(query, level, block_of(level, list.node), reach);
      lists_left += share_points(bounds, level, lists, list, stack + lists_left);
    }
  }
}

}  // namespace

extern const PointDescentKernels point_descent_kernels;
const PointDescentKernels point_descent_kernels = {load_points, descend_points};

}  // namespace weft::bsi::WEFT_KERNELS
