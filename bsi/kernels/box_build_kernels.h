// The loops that build a box pyramid, one table per instruction set. An internal header of bsi/.
#pragma once

#include <cstdint>

#include "bsi/detail/bound_rows.h"
#include "bsi/detail/box_layout.h"

namespace weft::bsi {

// The planes [begin, end) of a BoundRow that a kernel processes.
struct PlaneRange {
  int begin, end;
};
inline constexpr PlaneRange box_planes{0, 6};
inline constexpr PlaneRange step_planes{6, 18};

struct BoxBuildKernels {
  // Bounds each column of vertices over two or three rows. Writes to the box planes of `out`. With
  // `join` the bounds also include the previous contents of these planes.
  void (*bound_columns)(const VertexRows& rows, int quad_cols, bool join, BoundRow out);
  // Bounds the steps of two to five rows: along u from each column to the next, and along v within
  // each column. Writes to the step planes of `out`. With `join` the bounds also include the
  // previous contents of these planes.
  void (*bound_steps)(const VertexRows& rows, int quad_cols, bool join, BoundRow out);
  // Bounds leaf blocks from bounded columns of vertices. Block u spans the quads [boundary[u],
  // boundary[u + 1]).
  void (*bound_leaves)(BoundRow columns, PlaneRange planes, const std::int32_t* boundary,
                       int blocks, BoundRow out);
  // Bounds parents from two rows of their children. `upper` and `lower` may be the same row.
  void (*merge)(BoundRow upper, BoundRow lower, PlaneRange planes, bool split_u, int blocks,
                BoundRow out);
  // Stores the boxes of the children of a row of parents. If the parents are not split along v,
  // lower.plane is null.
  void (*store_groups)(BoundRow upper, BoundRow lower, bool split_u, int blocks, BoxGroup* out);
  void (*store_tangents)(BoundRow row, int blocks, TangentBounds* out);
};

// Returns the table for instruction_set().
const BoxBuildKernels& box_build_kernels();

}  // namespace weft::bsi
