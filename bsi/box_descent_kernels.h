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

// Points in float32, and by how much their boxes and those of the leaves are to be widened.
struct PointSet {
  const float *x, *y, *z, *half;
  std::int32_t count;
};
// A list of all of them, and those of four children on each of at most 18 levels.
constexpr std::size_t point_workspace(std::size_t count) { return (4 * 18 + 1) * (count + 8); }

struct DescentKernels {
  // The pairs that follow a pair of blocks whose widened boxes overlap, into next[0 .. 15]; their
  // number, or -1 for two leaf blocks.
  int (*expand)(const DescentQuery& query, const NodePair& pair, NodePair* next,
                DescentCounters& counters);
  // All pairs of leaves below such a pair.
  void (*descend)(const DescentQuery& query, const NodePair& pair, PairSink& sink,
                  DescentCounters& counters);
  // The leaves below the root of `patch` whose boxes, widened by what belongs to the point, overlap
  // the box of a point widened by the same; appended as pairs (first_number + point, leaf), leaf
  // block by leaf block. query.half_margin must be 0. `workspace` holds point_workspace(count)
  // numbers.
  void (*descend_points)(const DescentQuery& query, int patch, const PointSet& points,
                         int first_number, std::int32_t* workspace, PairSink& sink,
                         DescentCounters& counters);
};

// Of instruction_set().
const DescentKernels& descent_kernels();

}  // namespace weft::bsi
