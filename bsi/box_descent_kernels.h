// The loops that descend box pyramids, one table for each instruction set. An internal header of
// bsi/.
#pragma once

#include <cstdint>

#include "bsi/box_layout.h"

namespace weft::bsi {

struct LeafPair;

// Two blocks that may come near each other. In a self traversal, a == b stands for the block with
// itself.
struct NodePair {
  BoxNode a, b;
};

struct DescentQuery {
  const BoxTree* a;
  const BoxTree* b;           // a itself in a self traversal
  double certificate_margin;  // negative: the certificate is not to be used
  float half_margin;          // every box is widened by it
  bool self;
  bool triangles;  // leaves are triangles, not quads
};

struct DescentCounters {
  std::int64_t box_tests;
  std::int64_t certificate_tests;
  std::int64_t certified;
};

// Where leaf pairs go: `flush` is called when there may be no room for two leaf blocks' more, and
// empties it.
inline constexpr int pairs_a_flush = 8 * 8 + 8;
struct PairSink {
  LeafPair* pairs;
  int count;
  int capacity;
  void (*flush)(PairSink& sink);
  void* owner;
};

inline constexpr int largest_expansion = 16;

struct DescentKernels {
  // The pairs that follow a pair of blocks whose widened boxes overlap, into next[0 .. 15]; their
  // number, or -1 for two leaf blocks.
  int (*expand)(const DescentQuery& query, const NodePair& pair, NodePair* next,
                DescentCounters& counters);
  // All pairs of leaves below such a pair.
  void (*descend)(const DescentQuery& query, const NodePair& pair, PairSink& sink,
                  DescentCounters& counters);
  // The leaves below the root of `patch` whose widened box holds a point given in float32; appended
  // as pairs (point_number, leaf).
  void (*descend_point)(const DescentQuery& query, int patch, const float point[3],
                        int point_number, PairSink& sink, DescentCounters& counters);
};

// Of instruction_set().
const DescentKernels& descent_kernels();

}  // namespace weft::bsi
