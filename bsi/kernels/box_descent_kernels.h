// The loops that descend box pyramids, one table per instruction set. An internal header of bsi/.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsi/leaf_pair.h"

namespace weft::bsi {

// Two blocks that may come near each other. In a self traversal, a == b stands for a block paired
// with itself.
struct NodePair {
  BoxNode a, b;
};

struct DescentQuery {
  const BoxTree* a;
  const BoxTree* b;           // equal to `a` in a self traversal; only `b` may have a placement
  double certificate_margin;  // distance that the certificate must prove, m; negative if unused
  float half_margin;          // widening of every box on each side, m
  float sphere_reach;         // largest distance at which two spheres are not rejected, m
  Bound bound;
  bool self;
  bool triangles;        // true: leaves are triangles; false: quads
  std::uint64_t serial;  // number of the query, not 0; tags cached leaves
};

struct DescentCounters {
  std::int64_t bound_tests;
  std::int64_t certificate_tests;
  std::int64_t certified;
};

// Receives pairs of leaf blocks. `flush` empties the sink. A descent calls it when the sink is
// full.
struct BlockSink {
  LeafBlockPair* blocks;
  int count;
  int capacity;
  void (*flush)(BlockSink& sink);
  void* owner;
};

// Largest number of pairs of children of a pair of blocks.
inline constexpr int largest_expansion = 16;

// Number of leaf blocks of each body for which a workspace caches the boxes of the leaves.
inline constexpr std::size_t leaf_cache_size = 2048;
// Capacity of a list of pairs of blocks, and largest number of lists (one per level).
inline constexpr int pair_list_size = 1104, list_limit = 18;
// Bytes of the workspace of a thread's descents. The workspace must be aligned to 64 bytes, and
// filled with zeros when new.
inline constexpr std::size_t descent_workspace =
    2 * leaf_cache_size * (192 + 8) + std::size_t{8} * pair_list_size * list_limit + 64;

struct DescentKernels {
  // Writes those pairs of the two blocks' children whose bounds overlap to next[0 .. 15], and
  // returns their number. The number is 0 if the certificate proves that the two blocks cannot
  // touch, and -1 for two leaf blocks.
  int (*expand)(const DescentQuery& query, const NodePair& pair, NodePair* next,
                DescentCounters& counters);
  // Finds, below a pair of blocks, the pairs of leaves with overlapping widened boxes. A self
  // descent leaves out triangles that share a particle, and pairs that the certificate excludes.
  void (*descend)(const DescentQuery& query, const NodePair& pair, void* workspace, BlockSink& sink,
                  DescentCounters& counters);
  // Converts `count` pairs of leaf blocks to pairs of leaf indices, in order, and returns the
  // number of pairs of leaves. May write up to eight pairs past the end.
  std::size_t (*number)(const DescentQuery& query, const LeafBlockPair* blocks, std::size_t count,
                        LeafPair* pairs);
};

// Returns the table for instruction_set().
const DescentKernels& descent_kernels();

}  // namespace weft::bsi
