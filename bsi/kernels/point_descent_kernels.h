// The loop that descends a box pyramid with points, one table per instruction set. An internal
// header of bsi/.
#pragma once

#include "bsi/kernels/box_descent_kernels.h"

namespace weft::bsi {

// Largest number of points in a batch. Larger batches leave fewer vectors half empty.
inline constexpr int points_per_batch = 65536;
// Total capacity of the lists of points near a block: one list of all points, and one for each of
// four children on each of at most 18 levels. Every list has room for one more vector.
inline constexpr std::size_t point_list_length = (4 * 18 + 1) * (points_per_batch + 16);
// Bytes of a workspace: coordinates and indices of these points, and the half margin of each point.
// The workspace must be aligned to 64 bytes. Most of it is never touched.
inline constexpr std::size_t point_workspace =
    16 * point_list_length + 4 * std::size_t{points_per_batch + 16};

// Receives leaf pairs. `flush` empties the sink; a descent calls it when the pairs of one more leaf
// block might not fit.
inline constexpr int pairs_per_flush = 8;
struct PairSink {
  LeafPair* pairs;
  int count;
  int capacity;
  void (*flush)(PairSink& sink);
  void* owner;
};

struct PointDescentKernels {
  // Converts at most points_per_batch points (x, y, z each, m) to float32 and computes
  // half_margin(reach, magnitude, ...) of each. Returns the largest half margin. Precondition:
  // `reach` <= 4 * Pyramid::coordinate_limit.
  float (*load_points)(const double* positions, int count, double reach, float magnitude,
                       void* workspace);
  // Finds the leaves below the root of `patch` whose boxes overlap the box of a point, both widened
  // by that point's half margin. Appends pairs (first_number + point, leaf), leaf block by leaf
  // block, for the `count` points loaded last. Preconditions: query.half_margin is 0,
  // `largest_half` is the result of load_points, and `workspace` holds point_workspace bytes.
  void (*descend_points)(const DescentQuery& query, int patch, int count, float largest_half,
                         int first_number, void* workspace, PairSink& sink,
                         DescentCounters& counters);
};

// Returns the table for instruction_set().
const PointDescentKernels& point_descent_kernels();

}  // namespace weft::bsi
