// The loops that descend box pyramids, one table per instruction set. An internal header of bsi/.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsi/leaf_pair.h"

namespace weft::bsi {

// Two blocks that may come near each other. In a self traversal, a == b pairs a block with itself.
struct NodePair {
  BoxNode a, b;
};

struct DescentQuery {
  const BoxTree* a;
  const BoxTree* b;           // equals `a` in a self traversal; only b may have a placement
  double certificate_margin;  // negative: the certificate is not used
  float half_margin;          // m, added on all sides of every box
  float sphere_reach;  // m; spheres farther apart contain no leaves whose widened boxes overlap
  Bound bound;
  bool self;
  bool triangles;        // leaves are triangles, not quads
  std::uint64_t serial;  // number of the query, not 0: tags the leaves cached for it
};

struct DescentCounters {
  std::int64_t bound_tests;
  std::int64_t certificate_tests;
  std::int64_t certified;
};

// Receives pairs of leaf blocks. `flush` empties the sink; a descent calls it when the sink is
// full.
struct BlockSink {
  LeafBlockPair* blocks;
  int count;
  int capacity;
  void (*flush)(BlockSink& sink);
  void* owner;
};

inline constexpr int largest_expansion = 16;

// Bytes of the workspace of a thread's descents. It holds the leaf boxes used last, on both sides,
// and one list of pairs per level. It must be aligned to 64 bytes, and filled with zeros when new.
inline constexpr std::size_t leaf_cache_size = 2048;
inline constexpr int pair_list_size = 1104, list_limit = 18;
inline constexpr std::size_t descent_workspace =
    2 * leaf_cache_size * (192 + 8) + std::size_t{8} * pair_list_size * list_limit + 64;

struct DescentKernels {
  // Writes the pairs of children of two blocks whose bounds overlap to next[0 .. 15] and returns
  // their number. The number is 0 if the certificate proves that the blocks cannot touch, and -1
  // for two leaf blocks.
  int (*expand)(const DescentQuery& query, const NodePair& pair, NodePair* next,
                DescentCounters& counters);
  // Finds, below a pair of blocks, all pairs of leaves whose widened boxes overlap.
  void (*descend)(const DescentQuery& query, const NodePair& pair, void* workspace, BlockSink& sink,
                  DescentCounters& counters);
  // Converts `count` pairs of leaf blocks to pairs of leaf numbers, in order, and returns the
  // number of pairs. May write up to eight pairs past the end.
  std::size_t (*number)(const DescentQuery& query, const LeafBlockPair* blocks, std::size_t count,
                        LeafPair* pairs);
};

// Returns the table for instruction_set().
const DescentKernels& descent_kernels();

}  // namespace weft::bsi
