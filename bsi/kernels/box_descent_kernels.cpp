// Loops that descend box pyramids. Compiled once per instruction set: see
// bsi/detail/instruction_set.h for the restrictions.
#include "bsi/kernels/box_descent_kernels.h"

#include "bsi/kernels/leaf_blocks.h"
#include "bsi/kernels/shared_particles.h"
#include "bsi/kernels/store_pairs.h"
#include "bsi/kernels/tangent_certificate.h"
#include "bsi/leaf_pair.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

// --- Pairs of blocks ---

// A Place is the position of a block in its level: u in the low 16 bits, v in the high 16 bits.
// Places holds the Place of a first block in the low 32 bits and that of a second block in the high
// 32 bits.
typedef std::uint32_t Place;
typedef std::uint64_t Places;

WEFT_INLINE int u_of(Place place) { return static_cast<int>(place & 0xffff); }
WEFT_INLINE int v_of(Place place) { return static_cast<int>(place >> 16); }
WEFT_INLINE Place first_of(Places pair) { return static_cast<Place>(pair); }
WEFT_INLINE Place second_of(Places pair) { return static_cast<Place>(pair >> 32); }
WEFT_INLINE BoxNode node_of(int level, Place place) {
  return {level, static_cast<std::uint16_t>(place), static_cast<std::uint16_t>(place >> 16)};
}
WEFT_INLINE Place place_of(BoxNode node) { return node.u | static_cast<Place>(node.v) << 16; }

// A list of pairs of blocks. All first blocks are on one level, and all second blocks are on one
// level. Both descend together until they are leaf blocks.
struct PairList {
  const BoxLevel *a, *b;
  std::int32_t level_a, level_b;  // indices of `a` and `b` in BoxTree::levels
  Places split;                   // mask of the coordinates that double on the next level
  Places* pairs;
  int count;
};

WEFT_INLINE PairList list_of(const DescentQuery& query, int level_a, int level_b, Places* pairs) {
  const BoxLevel &a = query.a->levels[level_a], &b = query.b->levels[level_b];
  constexpr Places all = 0xffff;
  const Places split = (a.split_u != 0 ? all : 0) | (a.split_v != 0 ? all << 16 : 0) |
                       (b.split_u != 0 ? all << 32 : 0) | (b.split_v != 0 ? all << 48 : 0);
  return {&a, &b, level_a, level_b, split, pairs, 0};
}
WEFT_INLINE bool holds_leaf_blocks(const PairList& list) {
  return is_leaf(*list.a) && is_leaf(*list.b);
}
// Returns an empty list for the pairs of children of `list`. First and second blocks are one level
// lower, except leaf blocks.
WEFT_INLINE PairList list_below(const DescentQuery& query, const PairList& list, Places* pairs) {
  return list_of(query, list.level_a + (is_leaf(*list.a) ? 0 : 1),
                 list.level_b + (is_leaf(*list.b) ? 0 : 1), pairs);
}

WEFT_INLINE NodePair nodes_of(const PairList& list, Places pair) {
  return {node_of(list.level_a, first_of(pair)), node_of(list.level_b, second_of(pair))};
}
WEFT_INLINE Places places_of(const NodePair& nodes) {
  return place_of(nodes.a) | static_cast<Places>(place_of(nodes.b)) << 32;
}
WEFT_INLINE bool is_itself(const DescentQuery& query, const PairList& list, Places pair) {
  return query.self && list.level_a == list.level_b && first_of(pair) == second_of(pair);
}

// --- The workspace ---

// Boxes of the leaves of recently used leaf blocks. A descent may need the same leaf block many
// times.
struct LeafCache {
  LaneBoxes leaves[leaf_cache_size];
  std::uint64_t held[leaf_cache_size];  // level and place of each cached block
};

// Largest number of pairs that a descent expands at once, from the end of a list. The pairs of
// their children are appended to the next list.
constexpr int batch = 64;
static_assert(pair_list_size >= 17 * batch);

struct Workspace {
  LeafCache cache[2];  // first and second body; a self traversal uses cache[0]
  Places pairs[list_limit][pair_list_size];
  std::uint64_t serial;  // DescentQuery::serial of the cached leaves
  std::uint64_t unused[7];
};
static_assert(sizeof(Workspace) == descent_workspace);

WEFT_INLINE void forget_leaves_of_others(const DescentQuery& query, Workspace& work) {
  if (work.serial == query.serial) return;
  work.serial = query.serial;
  for (LeafCache& cache : work.cache) {
    for (std::uint64_t& held : cache.held) held = ~std::uint64_t{0};
  }
}

// Returns the widened boxes of the leaves of a block. The next call may overwrite them.
WEFT_INLINE const LaneBoxes& leaves_of(const DescentQuery& query, const BoxTree& tree, int level,
                                       Place place, LeafCache& cache) {
  static_assert(leaf_cache_size == 64 * 32);
  const unsigned at = (place & 63U) | (place >> 10 & (31U << 6));
  const std::uint64_t block = static_cast<std::uint64_t>(level) << 32 | place;
  if (cache.held[at] != block) {
    cache.held[at] = block;
    make_leaves(query, tree, node_of(level, place), cache.leaves[at]);
  }
  return cache.leaves[at];
}

// --- Leaves ---

// Masks of lane pairs, in which bit 8 i + j stands for lanes i and j. `upper_triangle` has the
// pairs with i <= j, `diagonal` those with i = j.
constexpr LanePairs upper_triangle = 0x80c0e0f0f8fcfeff;
constexpr LanePairs diagonal = 0x8040201008040201;

// Returns `near` without the pairs of triangles that share a particle. If a block is paired with
// itself, keeps only one of the pairs (i, j) and (j, i). Precondition: are_close() holds for the
// blocks.
WEFT_INLINE LanePairs without_shared(const DescentQuery& query, const NodePair& pair,
                                     LanePairs near) {
  const PlacedLeaves placed_a{pair.a, quads_of(*query.a, pair.a)};
  const PlacedLeaves placed_b{pair.b, quads_of(*query.b, pair.b)};
  const SharedParticles shared = shared_particles(query, placed_a, placed_b);
  near &= ~shared.lanes;
  // A quad is also paired with itself, because it can fold.
  if (query.self && same(pair.a, pair.b)) {
    near &= query.triangles ? upper_triangle & ~diagonal : upper_triangle;
  }
  return shared.look ? without_shared_particles(*query.a, placed_a, placed_b, near) : near;
}

// The data of a list that are_close() needs. If `never` or `always` is true, it decides for all
// pairs of the list. `round_*` is the distance, in blocks, of two neighbours across the seam of a
// wrapped axis. It is 1 if the axis is open.
struct Closeness {
  bool never, always;
  int round_u, round_v;
};

WEFT_INLINE Closeness closeness_of(const DescentQuery& query, const PairList& list) {
  const BoxPatch& patch = query.a->patches[list.a->patch];
  const bool sewn = query.a->texel_to_particle != nullptr;
  // Two bodies, and different patches that are not sewn, share no particle.
  return {!query.self || (!sewn && list.level_a != list.level_b), sewn,
          patch.wrap_u != 0 ? (1 << list.a->log_u) - 1 : 1,
          patch.wrap_v != 0 ? (1 << list.a->log_v) - 1 : 1};
}

// Returns false only if two blocks are neither neighbours nor share a particle. The code has no
// branches, because they would often be mispredicted.
WEFT_INLINE bool are_close(const Closeness& where, Places pair) {
  const Place a = first_of(pair), b = second_of(pair);
  const int u = u_of(a) - u_of(b), v = v_of(a) - v_of(b);
  const int far_u = u < 0 ? -u : u, far_v = v < 0 ? -v : v;
  const bool close =
      ((far_u <= 1) | (far_u == where.round_u)) & ((far_v <= 1) | (far_v == where.round_v));
  return (close & !where.never) | where.always;
}

// Tests the leaves of each pair of leaf blocks, and stores the pairs with near leaves. Most of the
// time of a descent is spent here.
WEFT_INLINE void pair_leaves(const DescentQuery& query, const PairList& list, Workspace& work,
                             BlockSink& sink, DescentCounters& counters) {
  counters.bound_tests += 64 * list.count;
  const Closeness where = closeness_of(query, list);
  const int level_a = list.level_a, level_b = list.level_b;
  LeafCache &cache_a = work.cache[0], &cache_b = work.cache[query.self ? 0 : 1];
  LeafBlockPair* to = sink.blocks + sink.count;
  for (int k = 0; k < list.count; ++k) {
    const Places pair = list.pairs[k];
    const Place a = first_of(pair), b = second_of(pair);
    const LaneBoxes* leaves_b = &leaves_of(query, *query.b, level_b, b, cache_b);
    const LaneBoxes* leaves_a = &leaves_of(query, *query.a, level_a, a, cache_a);
    LaneBoxes spare;
    if (leaves_a == leaves_b && (a != b || level_a != level_b)) {
      make_leaves(query, *query.b, node_of(level_b, b), spare);
      leaves_b = &spare;
    }
    LanePairs near = overlap_of_leaves(*leaves_a, *leaves_b);
    if (are_close(where, pair) && near != 0)
      near = without_shared(query, nodes_of(list, pair), near);
    if (to == sink.blocks + sink.capacity) {
      sink.count = sink.capacity;
      sink.flush(sink);
      to = sink.blocks;
    }
    // Every pair is stored, but the destination advances only if leaves are near. A branch would
    // often be mispredicted.
    to->a = node_of(level_a, a);
    to->b = node_of(level_b, b);
    to->leaves = near;
    to += near != 0 ? 1 : 0;
  }
  sink.count = static_cast<int>(to - sink.blocks);
}

// --- Expansion ---

// Appends the pairs of children whose bits are set in `near` and returns the end of the list. Bit 4
// i + j stands for child i of the first block and child j of the second. `pair` holds the two
// children with index 0. May write up to sixteen pairs.
WEFT_INLINE Places* append_children(Places pair, unsigned near, Places* to) {
#if defined(__AVX512DQ__)
  const __m512i all = _mm512_set1_epi64(static_cast<long long>(pair));
  for (int i = 0; i < 4; i += 2) {
    const long long first = i == 0 ? 0 : 1LL << 16, second = first + 1;
    constexpr long long u = 1LL << 32, v = 1LL << 48;
    const __m512i children =
        _mm512_add_epi64(all, _mm512_setr_epi64(first, first + u, first + v, first + u + v, second,
                                                second + u, second + v, second + u + v));
    const auto mask = static_cast<__mmask8>(near >> (4 * i));
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi64(mask, children));
    to += __builtin_popcount(mask);
  }
#else
  for (; near != 0; near &= near - 1) {
    const auto bit = static_cast<Places>(__builtin_ctz(near));
    *to++ = pair + (bit >> 2 & 1) + (bit >> 3 << 16) + ((bit & 1) << 32) + ((bit >> 1 & 1) << 48);
  }
#endif
  return to;
}

WEFT_INLINE std::size_t block_at(const BoxLevel& level, Place place) {
  return (static_cast<std::size_t>(place >> 16) << level.log_u) + (place & 0xffff);
}

// Moves bit i, which stands for child i of the first block, to bit 4 i, as append_children()
// expects.
WEFT_INLINE unsigned as_children_of_first(unsigned near) {
  return (near | near << 3 | near << 6 | near << 9) & 0x1111U;
}

WEFT_INLINE unsigned near_by_boxes(const DescentQuery& query, const PairList& list, Places pair) {
  const auto group_of = [](const BoxLevel& level, Place place) -> const BoxGroup& {
    return level.groups[block_at(level, place)];
  };
  BoxGroup room;
  const auto children_of_second = [&]() -> const BoxGroup& {
    return in_space(*query.b, group_of(*list.b, second_of(pair)), room);
  };
  const bool leaf_a = is_leaf(*list.a), leaf_b = is_leaf(*list.b);
  if (!leaf_a && !leaf_b) {
    return overlap_of_children(group_of(*list.a, first_of(pair)), children_of_second(),
                               query.half_margin);
  }
  const NodePair nodes = nodes_of(list, pair);
  if (leaf_a) {
    return overlap_of_box(box_of(*query.a, nodes.a, query.half_margin), children_of_second(),
                          query.half_margin);
  }
  return as_children_of_first(overlap_of_box(box_of(*query.b, nodes.b, query.half_margin),
                                             group_of(*list.a, first_of(pair)), query.half_margin));
}

WEFT_INLINE unsigned near_by_spheres(const DescentQuery& query, const PairList& list, Places pair) {
  const auto group_of = [](const BoxLevel& level, Place place) -> const SphereGroup& {
    return level.spheres[block_at(level, place)];
  };
  SphereGroup room;
  const auto children_of_second = [&]() -> const SphereGroup& {
    return in_space(*query.b, group_of(*list.b, second_of(pair)), room);
  };
  const bool leaf_a = is_leaf(*list.a), leaf_b = is_leaf(*list.b);
  if (!leaf_a && !leaf_b) {
    return touch_of_children(group_of(*list.a, first_of(pair)), children_of_second(),
                             query.sphere_reach);
  }
  const NodePair nodes = nodes_of(list, pair);
  if (leaf_a) {
    return touch_of_sphere(sphere_of(*query.a, nodes.a), children_of_second(), query.sphere_reach);
  }
  return as_children_of_first(touch_of_sphere(
      sphere_of(*query.b, nodes.b), group_of(*list.a, first_of(pair)), query.sphere_reach));
}

// Returns the bits, as for append_children(), of those pairs of children whose bounds overlap. A
// leaf block counts as its own only child.
WEFT_INLINE unsigned near_of(const DescentQuery& query, const PairList& list, Places pair) {
  if (query.bound == Bound::box) return near_by_boxes(query, list, pair);
  const unsigned near = near_by_spheres(query, list, pair);
  if (query.bound == Bound::sphere || near == 0) return near;
  return near & near_by_boxes(query, list, pair);
}

// Appends the pairs of children of `pair` whose bounds overlap, and returns the end of the list.
// May write up to sixteen pairs.
WEFT_INLINE Places* append_following(const DescentQuery& query, const PairList& list, Places pair,
                                     Places* to) {
  // If a block is paired with itself, each pair of its children counts once. An absent child
  // overlaps nothing, not even itself.
  const unsigned once = is_itself(query, list, pair) ? 0x8cefU : 0xffffU;
  return append_children(pair + (pair & list.split), near_of(query, list, pair) & once, to);
}

WEFT_INLINE int tests_per_pair(const PairList& list) {
  return is_leaf(*list.a) || is_leaf(*list.b) ? 4 : 16;
}

int expand_pair(const DescentQuery& query, const NodePair& pair, NodePair* next,
                DescentCounters& counters) {
  if (query.self && cannot_touch(query, pair, counters)) return 0;
  const PairList list = list_of(query, pair.a.level, pair.b.level, nullptr);
  if (holds_leaf_blocks(list)) return -1;
  counters.bound_tests += tests_per_pair(list);
  Places found[2 * largest_expansion];
  const PairList below = list_below(query, list, found);
  const auto count = append_following(query, list, places_of(pair), found) - found;
  for (int i = 0; i < count; ++i) next[i] = nodes_of(below, found[i]);
  return static_cast<int>(count);
}

// Removes the pairs that the certificate proves not to touch, and returns the end of the list. A
// single test has a long latency. Many tests in a row, without branches between them, take little
// longer.
WEFT_INLINE Places* without_certified(const DescentQuery& query, const PairList& list, bool itself,
                                      Places* pairs, const Places* end, DescentCounters& counters) {
  unsigned left = 0;
  for (int i = 0; i < end - pairs; ++i) {
    const NodePair pair = nodes_of(list, pairs[i]);
    // The certificate of two diagonal children tests the rectangle of their parent, for which it
    // has already failed.
    const bool is_parent = itself && pair.a.u != pair.b.u && pair.a.v != pair.b.v;
    if (is_parent || !cannot_touch(query, pair, counters)) left |= 1U << i;
  }
  Places* kept = pairs;
  for (; left != 0; left &= left - 1) *kept++ = pairs[__builtin_ctz(left)];
  return kept;
}

// --- The descent ---

// Removes up to `batch` pairs from the end of a list and appends the pairs of their children to the
// next list.
WEFT_INLINE void expand_list(const DescentQuery& query, PairList& list, PairList& next,
                             DescentCounters& counters) {
  const int count = list.count < batch ? list.count : batch;
  list.count -= count;
  counters.bound_tests += tests_per_pair(list) * count;
  const Closeness where = closeness_of(query, list);
  const bool certifies = query.certificate_margin >= 0;
  Places* to = next.pairs + next.count;
  for (int k = list.count; k < list.count + count; ++k) {
    const Places pair = list.pairs[k];
    Places* const first = to;
    to = append_following(query, list, pair, first);
    if (certifies && are_close(where, pair))
      to = without_certified(query, next, is_itself(query, list, pair), first, to, counters);
  }
  next.count = static_cast<int>(to - next.pairs);
}

void descend(const DescentQuery& query, const NodePair& start, void* workspace, BlockSink& sink,
             DescentCounters& counters) {
  if (query.self && cannot_touch(query, start, counters)) return;
  auto& work = *static_cast<Workspace*>(workspace);
  forget_leaves_of_others(query, work);
  PairList lists[list_limit];
  lists[0] = list_of(query, start.a.level, start.b.level, work.pairs[0]);
  lists[0].pairs[lists[0].count++] = places_of(start);
  for (int at = 0; at >= 0;) {
    PairList& list = lists[at];
    if (holds_leaf_blocks(list)) {
      pair_leaves(query, list, work, sink, counters);
      --at;
    } else if (list.count > 0) {
      lists[at + 1] = list_below(query, list, work.pairs[at + 1]);
      expand_list(query, list, lists[++at], counters);
    } else {
      --at;
    }
  }
}

// --- Numbers of leaves ---

std::size_t number_pairs(const DescentQuery& query, const LeafBlockPair* blocks, std::size_t count,
                         LeafPair* pairs) {
  std::size_t stored = 0;
  for (std::size_t k = 0; k < count; ++k) {
    alignas(32) int number_a[8], number_b[8];
    number_leaves(*query.a, blocks[k].a, query.triangles, number_a);
    number_leaves(*query.b, blocks[k].b, query.triangles, number_b);
    for (std::uint64_t left = blocks[k].leaves; left != 0;) {
      const int i = __builtin_ctzll(left) / 8;
      const auto of_lane = static_cast<unsigned>(left >> (8 * i) & 0xff);
      stored += static_cast<std::size_t>(
          store_pairs(pairs + stored, of_lane, number_a[i], number_b, query.self));
      left &= ~(LanePairs{0xff} << (8 * i));
    }
  }
  return stored;
}

}  // namespace

extern const DescentKernels descent_kernels;
const DescentKernels descent_kernels = {expand_pair, descend, number_pairs};

}  // namespace weft::bsi::WEFT_KERNELS
