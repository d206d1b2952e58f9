// Compiled once for every instruction set: see instruction_set.h for what that forbids.
#include "bsi/box_descent_kernels.h"

#include "bsi/leaf_blocks.h"
#include "bsi/leaf_pair.h"
#include "bsi/shared_particles.h"
#include "bsi/store_pairs.h"
#include "bsi/tangent_certificate.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

// --- Leaves ---

// The leaf blocks of a block of up to 2 x 2 of them, as far as they were needed.
struct alignas(64) LeafGroup {
  LaneBoxes leaves[4];
  BoxNode node[4];
  BoxNode parent;
  std::uint64_t serial;  // of the query it was made for
  unsigned made;         // bits 0 .. 3: its leaf blocks that are made
};

// The groups used last: a descent comes back to each of them a few times.
constexpr unsigned cache_size = 64;
struct LeafCache {
  LeafGroup group[cache_size];
};
static_assert(2 * sizeof(LeafCache) == descent_workspace);

WEFT_INLINE LeafGroup& group_of(const DescentQuery& query, const BoxLevel& level, LeafCache& cache,
                                BoxNode parent) {
  LeafGroup& group = cache.group[(parent.u + 8U * parent.v) % cache_size];
  if (group.serial != query.serial || !same(group.parent, parent)) {
    group.serial = query.serial;
    group.parent = parent;
    for (int child = 0; child < 4; ++child) group.node[child] = child_of(level, parent, child);
    group.made = 0;
  }
  return group;
}

// Makes those of the leaf blocks that are needed (bits 0 .. 3) and not there.
WEFT_INLINE void complete(const DescentQuery& query, const BoxTree& tree, LeafGroup& group,
                          unsigned needed) {
  unsigned missing = needed & ~group.made;
  group.made |= needed;
  for (; missing != 0; missing &= missing - 1) {
    const int child = __builtin_ctz(missing);
    make_leaves(query, tree, group.node[child], group.leaves[child]);
  }
}

// Each pair of lanes of one block once.
constexpr LanePairs upper_triangle = 0x80c0e0f0f8fcfeff;
constexpr LanePairs diagonal = 0x8040201008040201;

// Keeps what counts of the lane pairs of two leaf blocks, and hands it on.
WEFT_INLINE void hand_on(const DescentQuery& query, const NodePair& pair, LanePairs near,
                         BlockSink& sink) {
  if (query.self && near != 0) {
    const PlacedLeaves placed_a{pair.a, quads_of(*query.a, pair.a)};
    const PlacedLeaves placed_b{pair.b, quads_of(*query.b, pair.b)};
    const SharedParticles shared = shared_particles(query, placed_a, placed_b);
    near &= ~shared.lanes;
    // A quad is paired with itself too: it can fold.
    if (query.self && same(pair.a, pair.b)) {
      near &= query.triangles ? upper_triangle & ~diagonal : upper_triangle;
    }
    if (shared.look) near = without_shared_particles(*query.a, placed_a, placed_b, near);
  }
  if (near == 0) return;
  if (sink.count == sink.capacity) sink.flush(sink);
  sink.blocks[sink.count++] = {pair.a, pair.b, near};
}

// --- Expansion ---

// Children i of the one and j of the other whose boxes overlap: bit 4 i + j. Of a block with
// itself, each pair once; a child that is not there does not even meet itself.
WEFT_INLINE unsigned near_children(const DescentQuery& query, const NodePair& pair,
                                   DescentCounters& counters) {
  const BoxLevel& level_a = level_of(*query.a, pair.a);
  const BoxLevel& level_b = level_of(*query.b, pair.b);
  counters.box_tests += 16;
  const unsigned near =
      overlap_of_children(level_a.groups[block_of(level_a, pair.a)],
                          level_b.groups[block_of(level_b, pair.b)], query.half_margin);
  return query.self && same(pair.a, pair.b) ? near & 0x8cefU : near;
}

WEFT_INLINE int expand_both(const DescentQuery& query, const NodePair& pair, NodePair* next,
                            DescentCounters& counters) {
  const BoxLevel& level_a = level_of(*query.a, pair.a);
  const BoxLevel& level_b = level_of(*query.b, pair.b);
  int count = 0;
  for (unsigned near = near_children(query, pair, counters); near != 0; near &= near - 1) {
    const int bit = __builtin_ctz(near);
    next[count++] = {child_of(level_a, pair.a, bit >> 2), child_of(level_b, pair.b, bit & 3)};
  }
  return count;
}

WEFT_INLINE int expand(const DescentQuery& query, const NodePair& pair, NodePair* next,
                       DescentCounters& counters) {
  const BoxLevel& level_a = level_of(*query.a, pair.a);
  const BoxLevel& level_b = level_of(*query.b, pair.b);
  const bool leaf_a = is_leaf(level_a), leaf_b = is_leaf(level_b);
  if (leaf_a && leaf_b) return -1;
  if (!leaf_a && !leaf_b) return expand_both(query, pair, next, counters);
  counters.box_tests += 4;
  const BoxTree& whole_tree = leaf_a ? *query.a : *query.b;
  const WideBox whole = box_of(whole_tree, leaf_a ? pair.a : pair.b, query.half_margin);
  const BoxLevel& split = leaf_a ? level_b : level_a;
  const BoxNode node = leaf_a ? pair.b : pair.a;
  unsigned near = overlap_of_box(whole, split.groups[block_of(split, node)], query.half_margin);
  int count = 0;
  for (; near != 0; near &= near - 1) {
    const BoxNode child = child_of(split, node, __builtin_ctz(near));
    next[count++] = leaf_a ? NodePair{pair.a, child} : NodePair{child, pair.b};
  }
  return count;
}

int expand_pair(const DescentQuery& query, const NodePair& pair, NodePair* next,
                DescentCounters& counters) {
  if (query.self && cannot_touch(query, pair, counters)) return 0;
  return expand(query, pair, next, counters);
}

// False only if no blocks within the two are neighbours or have a particle in common.
WEFT_INLINE bool are_close(const BoxTree& tree, const NodePair& pair) {
  if (tree.texel_to_particle != nullptr) return true;
  if (pair.a.level != pair.b.level) return false;  // patches that are not sewn
  const BoxLevel& level = level_of(tree, pair.a);
  const BoxPatch& patch = tree.patches[level.patch];
  int step = 0;
  return are_neighbours(pair.a.u, pair.b.u, 1 << level.log_u, patch.wrap_u != 0, step) &&
         are_neighbours(pair.a.v, pair.b.v, 1 << level.log_v, patch.wrap_v != 0, step);
}

// Those of the pairs that follow a pair that may touch; their number. One test takes long until it
// is known, but many in a row, between which nothing is decided, hardly longer.
WEFT_INLINE int without_certified(const DescentQuery& query, const NodePair& parent, int count,
                                  NodePair* pairs, DescentCounters& counters) {
  const bool itself = same(parent.a, parent.b);
  unsigned left = 0;
  for (int i = 0; i < count; ++i) {
    const NodePair& pair = pairs[i];
    // The window of two children at a corner is their parent, which was not proved apart.
    const bool is_parent = itself && pair.a.u != pair.b.u && pair.a.v != pair.b.v;
    if (is_parent || !cannot_touch(query, pair, counters)) left |= 1U << i;
  }
  int kept = 0;
  for (; left != 0; left &= left - 1) pairs[kept++] = pairs[__builtin_ctz(left)];
  return kept;
}

// Bit i: one of bits 4 i .. 4 i + 3 is set.
WEFT_INLINE unsigned rows_of(unsigned near) {
  near |= near >> 2;
  near = (near | near >> 1) & 0x1111U;
  return (near | near >> 3 | near >> 6 | near >> 9) & 15U;
}

// Two blocks of leaf blocks at once: nearly all pairs of a descent are found here.
WEFT_INLINE void pair_groups(const DescentQuery& query, const NodePair& pair, LeafCache* cache,
                             BlockSink& sink, DescentCounters& counters) {
  const BoxLevel& level_a = level_of(*query.a, pair.a);
  const BoxLevel& level_b = level_of(*query.b, pair.b);
  unsigned near = near_children(query, pair, counters);
  if (near == 0) return;
  LeafGroup& group_a = group_of(query, level_a, cache[0], pair.a);
  LeafGroup& group_b = group_of(query, level_b, cache[1], pair.b);
  complete(query, *query.a, group_a, rows_of(near));
  complete(query, *query.b, group_b, (near | near >> 4 | near >> 8 | near >> 12) & 15U);
  counters.box_tests += 64 * __builtin_popcount(near);
  if (query.self && are_close(*query.a, pair)) {
    for (; near != 0; near &= near - 1) {
      const int bit = __builtin_ctz(near), i = bit >> 2, j = bit & 3;
      hand_on(query, {group_a.node[i], group_b.node[j]},
              overlap_of_leaves(group_a.leaves[i], group_b.leaves[j]), sink);
    }
    return;
  }
  // Every pair is written, and the place moves on where it counts: to jump would be mispredicted as
  // often as not.
  if (sink.capacity - sink.count < 16) sink.flush(sink);
  LeafBlockPair* to = sink.blocks + sink.count;
  for (; near != 0; near &= near - 1) {
    const int bit = __builtin_ctz(near), i = bit >> 2, j = bit & 3;
    const LanePairs lanes = overlap_of_leaves(group_a.leaves[i], group_b.leaves[j]);
    *to = {group_a.node[i], group_b.node[j], lanes};
    to += lanes != 0 ? 1 : 0;
  }
  sink.count = static_cast<int>(to - sink.blocks);
}

// --- The descent ---

WEFT_INLINE bool holds_leaf_blocks(const BoxTree& tree, BoxNode node) {
  return !is_leaf(level_of(tree, node)) && is_leaf(tree.levels[node.level + 1]);
}

// Every step takes one pair off and puts at most sixteen on, on at most 2 x 17 levels.
constexpr int stack_size = 16 * 2 * 18;

void descend(const DescentQuery& query, const NodePair& start, void* workspace, BlockSink& sink,
             DescentCounters& counters) {
  if (query.self && cannot_touch(query, start, counters)) return;
  const bool certifies = query.certificate_margin >= 0;
  auto* cache = static_cast<LeafCache*>(workspace);
  NodePair stack[stack_size];
  int count = 0;
  stack[count++] = start;
  while (count > 0) {
    const NodePair pair = stack[--count];
    if (holds_leaf_blocks(*query.a, pair.a) && holds_leaf_blocks(*query.b, pair.b)) {
      pair_groups(query, pair, cache, sink, counters);
      continue;
    }
    const int expanded = expand(query, pair, stack + count, counters);
    if (expanded >= 0) {
      count += certifies && are_close(*query.a, pair)
                   ? without_certified(query, pair, expanded, stack + count, counters)
                   : expanded;
      continue;
    }
    // Images of unlike size, or so small that they are leaf blocks themselves.
    LaneBoxes a, b;
    make_leaves(query, *query.a, pair.a, a);
    make_leaves(query, *query.b, pair.b, b);
    counters.box_tests += 64;
    hand_on(query, pair, overlap_of_leaves(a, b), sink);
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
