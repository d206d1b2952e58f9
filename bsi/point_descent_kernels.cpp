// Compiled once for every instruction set: see instruction_set.h for what that forbids.
#include "bsi/point_descent_kernels.h"

#include "bsi/leaf_blocks.h"
#include "bsi/store_pairs.h"
#include "bsi/wide_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

// Lists of points in the workspace: components, by how much each is widened, and numbers. They are
// copied from level to level, so that every list lies in a row.
struct PointLists {
  float* value[4];  // x, y, z, half
  std::int32_t* number;
};

WEFT_INLINE PointLists lists_in(void* workspace, std::size_t count) {
  const std::size_t length = point_list_length(count);
  auto* numbers = static_cast<std::int32_t*>(workspace);
  auto* floats = reinterpret_cast<float*>(numbers + length);
  return {{floats, floats + length, floats + 2 * length, floats + 3 * length}, numbers};
}

// Some points that come near a block.
struct PointList {
  BoxNode node;
  std::int32_t first, count;
};

// Copies points from + i for the bits i of the mask to place `to` and on; their number. May write
// a whole vector.
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

// The points in lanes whose boxes, widened by what belongs to each, overlap a box widened by the
// same.
WEFT_INLINE unsigned overlap_of_points(const Wide (&point)[3], Wide half, const float (&low)[3],
                                       const float (&high)[3]) {
#if defined(__AVX512F__)
  __mmask16 mask = 0xffff;
  for (int axis = 0; axis < 3; ++axis) {
    const Wide box_low = low[axis] - half, box_high = high[axis] + half;
    mask = _mm512_mask_cmp_ps_mask(mask, box_low, point[axis] + half, _CMP_LE_OQ);
    mask = _mm512_mask_cmp_ps_mask(mask, point[axis] - half, box_high, _CMP_LE_OQ);
  }
  return mask;
#else
  WideBits meets = WideBits{} - 1;
  for (int axis = 0; axis < 3; ++axis) {
    meets &= (low[axis] - half <= point[axis] + half) & (point[axis] - half <= high[axis] + half);
  }
  unsigned mask = 0;
  for (int lane = 0; lane < width; ++lane) mask |= meets[lane] != 0 ? 1U << lane : 0U;
  return mask;
#endif
}

// The lists of the children of a block, one after the other behind its own, each with room for a
// vector more.
int share_points(const BoxGroup& group, const BoxLevel& level, const PointLists& lists,
                 const PointList& list, PointList* next) {
  const std::int32_t end = list.first + list.count + width;
  const std::int32_t room = list.count + width;
  std::int32_t counts[4] = {};
  for (int i = 0; i < list.count; i += width) {
    const int from = list.first + i;
    const Wide half = load_wide(lists.value[3] + from);
    const Wide point[3] = {load_wide(lists.value[0] + from), load_wide(lists.value[1] + from),
                           load_wide(lists.value[2] + from)};
    const unsigned there =
        list.count - i < width ? (1U << (list.count - i)) - 1 : (1U << (width - 1)) * 2 - 1;
    for (int child = 0; child < 4; ++child) {
      const float low[3] = {group.low[0][child], group.low[1][child], group.low[2][child]};
      const float high[3] = {group.high[0][child], group.high[1][child], group.high[2][child]};
      const unsigned near = overlap_of_points(point, half, low, high) & there;
      if (near == 0) continue;
      counts[child] += copy_marked(lists, from, near, end + child * room + counts[child]);
    }
  }
  int shared = 0;
  for (int child = 0; child < 4; ++child) {
    if (counts[child] == 0) continue;
    next[shared++] = {child_of(level, list.node, child), end + child * room, counts[child]};
  }
  return shared;
}

void pair_points(const DescentQuery& query, const PointLists& lists, const PointList& list,
                 int first_number, PairSink& sink) {
  Leaves<1> leaves;
  make_leaves(query, *query.a, list.node, leaves);
  alignas(32) int number[8];
  number_leaves(*query.a, list.node, query.triangles, number);
  for (int i = list.first; i < list.first + list.count; ++i) {
    const float half = lists.value[3][i];
    const float at[3] = {lists.value[0][i], lists.value[1][i], lists.value[2][i]};
    LaneBoxes boxes = boxes_of(leaves), box;
    for (int axis = 0; axis < 3; ++axis) {
      boxes.low[axis] -= half;
      boxes.high[axis] += half;
      box.low[axis] = broadcast(at[axis] - half);
      box.high[axis] = broadcast(at[axis] + half);
    }
    if (sink.count + pairs_a_flush > sink.capacity) sink.flush(sink);
    sink.count += store_pairs(sink.pairs + sink.count, overlap(boxes, box),
                              first_number + lists.number[i], number, false);
  }
}

void descend_points(const DescentQuery& query, int patch, const PointSet& points, int first_number,
                    void* workspace, PairSink& sink, DescentCounters& counters) {
  const BoxTree& tree = *query.a;
  const PointLists lists = lists_in(workspace, static_cast<std::size_t>(points.count));
  for (int i = 0; i < points.count; ++i) {
    lists.value[0][i] = points.x[i];
    lists.value[1][i] = points.y[i];
    lists.value[2][i] = points.z[i];
    lists.value[3][i] = points.half[i];
    lists.number[i] = i;
  }
  PointList stack[4 * 18];
  stack[0] = {{tree.patches[patch].first_level, 0, 0}, 0, points.count};
  for (int count = 1; count > 0;) {
    const PointList list = stack[--count];
    const BoxLevel& level = level_of(tree, list.node);
    if (is_leaf(level)) {
      counters.box_tests += 8 * list.count;
      pair_points(query, lists, list, first_number, sink);
    } else {
      counters.box_tests += 4 * list.count;
      const BoxGroup& group = level.groups[block_of(level, list.node)];
      count += share_points(group, level, lists, list, stack + count);
    }
  }
}

}  // namespace

extern const PointDescentKernels point_descent_kernels;
const PointDescentKernels point_descent_kernels = {descend_points};

}  // namespace weft::bsi::WEFT_KERNELS
