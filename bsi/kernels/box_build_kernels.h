// The loops that build a box pyramid, one table per instruction set. An internal header of bsi/.
#pragma once

#include <cstdint>

#include "bsi/detail/bound_rows.h"
#include "bsi/detail/box_layout.h"

namespace weft::bsi {

// The planes that a kernel processes.
struct PlaneRange {
  int begin, end;
};
inline constexpr PlaneRange box_planes{0, 6};
inline constexpr PlaneRange step_planes{6, 18};

struct BoxBuildKernels {
  // Bounds each column of vertices over two or three rows, for the planes of boxes. With `join` the
  // bounds include the previous contents of `out`.
  void (*bound_columns)(const VertexRows& rows, int quad_cols, bool join, BoundRow out);
  // Bounds, over two to five rows, the steps along u from each column to the next and the steps
  // along v within the column.
  void (*bound_steps)(const VertexRows& rows, int quad_cols, bool join, BoundRow out);
  // Makes leaf blocks from bounded columns. Block u spans the quads [boundary[u], boundary[u + 1]).
  void (*bound_leaves)(BoundRow columns, PlaneRange planes, const std::int32_t* boundary,
                       int blocks, BoundRow out);
  // Makes parents from one or two rows of children (upper == lower if v is not split).
  void (*merge)(BoundRow upper, BoundRow lower, PlaneRange planes, bool split_u, int blocks,
                BoundRow out);
  // Stores the child boxes of a row of parents. `lower.plane` is null if v is not split.
  void (*store_groups)(BoundRow upper, BoundRow lower, bool split_u, int blocks, BoxGroup* out);
  void (*store_tangents)(BoundRow row, int blocks, TangentBounds* out);
};

// Returns the table for instruction_set().
const BoxBuildKernels& box_build_kernels();

}  // namespace weft::bsi
