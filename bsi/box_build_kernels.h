// The loops that build a box pyramid, one table for each instruction set. An internal header of
// bsi/.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsi/box_layout.h"

namespace weft::bsi {

// A row of blocks while the pyramid is built: `planes` arrays of one float a block, `stride` apart.
// Planes 0-5 bound the vertices, 6-17 the steps between them (TangentBounds::bound); lower bounds
// have their sign changed, so that every union is a maximum.
inline constexpr int box_planes = 6;
inline constexpr int all_planes = 18;
// Every plane may be read and written to a multiple of this many blocks.
inline constexpr int plane_padding = 16;
struct BoundRow {
  float* plane;
  std::size_t stride;
  int planes;  // box_planes where steps are not wanted
};

// The two or three rows of vertices that a row of leaf blocks spans.
struct VertexRows {
  const float* row[3][3];  // by row, by component
  std::int32_t count;      // 2 or 3
};

struct BoxBuildKernels {
  // Rounds `count` positions (three doubles each; picked by `particle` unless null) to float32.
  // False if one of them reaches `limit` or is not a number.
  bool (*load_vertices)(const double* positions, const std::int32_t* particle, int count,
                        float limit, float* const component[3]);
  // Bounds, over the rows, of each vertex column (planes 0-5 and 12-17 of the steps along v) and of
  // each column of steps along u. `join`: together with what `out` holds.
  void (*bound_columns)(const VertexRows& rows, int quad_cols, bool join, BoundRow out);
  // Leaf blocks from bounded columns; block u spans the quads [boundary[u], boundary[u + 1]).
  void (*bound_leaves)(BoundRow columns, const std::int32_t* boundary, int blocks, BoundRow out);
  // Parents from one or two rows of children (upper == lower where v is not split).
  void (*merge)(BoundRow upper, BoundRow lower, bool split_u, int blocks, BoundRow out);
  // The child boxes of a row of parents. `lower.plane` is null where v is not split.
  void (*store_groups)(BoundRow upper, BoundRow lower, bool split_u, int blocks, BoxGroup* out);
  void (*store_tangents)(BoundRow row, int blocks, TangentBounds* out);
};

// Of instruction_set().
const BoxBuildKernels& box_build_kernels();

}  // namespace weft::bsi
