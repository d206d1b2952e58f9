// The loop that brings points down a box pyramid, one table for each instruction set. An internal
// header of bsi/.
#pragma once

#include "bsi/box_descent_kernels.h"

namespace weft::bsi {

// Points in float32, and by how much their boxes and those of the leaves are to be widened.
struct PointSet {
  const float *x, *y, *z, *half;
  std::int32_t count;
};
// A list of all of them, and those of four children on each of at most 18 levels, each with room
// for a vector more.
constexpr std::size_t point_list_length(std::size_t count) { return (4 * 18 + 1) * (count + 16); }
// Bytes of a workspace: the numbers, components and widths of those; aligned to 64.
constexpr std::size_t point_workspace(std::size_t count) { return 20 * point_list_length(count); }

// Where leaf pairs go: `flush` is called when there may be no room for a leaf block's more, and
// empties it.
inline constexpr int pairs_a_flush = 8;
struct PairSink {
  LeafPair* pairs;
  int count;
  int capacity;
  void (*flush)(PairSink& sink);
  void* owner;
};

struct PointDescentKernels {
  // The leaves below the root of `patch` whose boxes, widened by what belongs to the point, overlap
  // the box of a point widened by the same; appended as pairs (first_number + point, leaf), leaf
  // block by leaf block. query.half_margin must be 0. `workspace` holds point_workspace(count)
  // bytes.
  void (*descend_points)(const DescentQuery& query, int patch, const PointSet& points,
                         int first_number, void* workspace, PairSink& sink,
                         DescentCounters& counters);
};

// Of instruction_set().
const PointDescentKernels& point_descent_kernels();

}  // namespace weft::bsi
