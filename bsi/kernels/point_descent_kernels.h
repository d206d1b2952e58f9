// The loop that descends a box pyramid with points, one table per instruction set. An internal
// header of bsi/.
#pragma once

#include "bsi/kernels/box_descent_kernels.h"

namespace weft::bsi {

// Largest number of points in a batch. In larger batches, fewer vectors are half empty.
inline constexpr int points_per_batch = 65536;
// Total capacity of the lists of points near blocks. There is one list of all points, and one for
// each of four children on each of at most 18 levels. Every list has room for one more vector.
inline constexpr std::size_t point_list_length = (4 * 18 + 1) * (points_per_batch + 16);
// Bytes of a workspace for descend_points(). It holds the coordinates and indices of the points in
// all lists, and the half margin of each point. It must be aligned to 64 bytes. Most of it is
// rarely touched.
inline constexpr std::size_t point_workspace =
    16 * point_list_length + 4 * std::size_t{points_per_batch + 16};

// Largest number of pairs that a point forms with the leaves of one leaf block.
inline constexpr int pairs_per_flush = 8;
// Receives pairs of a point and a leaf. `flush` empties the sink. A descent calls it when fewer
// than pairs_per_flush more pairs fit.
struct PairSink {
  LeafPair* pairs;
  int count;
  int capacity;
  void (*flush)(PairSink& sink);
  void* owner;
};

struct PointDescentKernels {
  // Converts at most points_per_batch points (x, y, z each, m) to float32 and computes
  // half_margin(reach, magnitude, ...) of each point. Returns the largest half margin (m).
  // Precondition: `reach` <= 4 * Pyramid::coordinate_limit.
  float (*load_points)(const double* positions, int count, double reach, float magnitude,
                       void* workspace);
  // Finds the leaves of `patch` near each of the `count` points loaded last. A leaf is near if its
  // box overlaps the point when both are widened by the point's half margin. Appends pairs
  // (first_number + point, leaf), leaf block by leaf block. Preconditions: query.half_margin is 0,
  // `largest_half` is the result of load_points, and `workspace` holds point_workspace bytes.
  void (*descend_points)(const DescentQuery& query, int patch, int count, float largest_half,
                         int first_number, void* workspace, PairSink& sink,
                         DescentCounters& counters);
};

// Returns the table for instruction_set().
const PointDescentKernels& point_descent_kernels();

}  // namespace weft::bsi
