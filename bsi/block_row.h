// Rows of vertices and of blocks in float32, one array a component, for vector instructions: what
// the pyramid is built through. Costs are linear in the row.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "bsi/block_levels.h"

namespace weft::bsi {

// x, y, z.
using Components = std::array<std::vector<float>, 3>;

// Vertices of an image row, the first one repeated at the end of a wrapped row. The second set is
// the other end of their paths, when swept.
using VertexRow = std::array<Components, 2>;

// Boxes of the float32 vertices of each block, and spheres that bound the float64 ones. An empty
// block has low > high, neutral to minima and maxima, and a negative radius.
struct BlockRow {
  Components low, high, centre;
  std::vector<float> radius;

  // Makes room for so many blocks; never shrinks.
  void reserve(std::size_t blocks);
  // Makes the first `blocks` blocks empty.
  void clear(int blocks);
};

// The blocks of a row of single quads between two rows of vertices, at one or both (`ends`) ends of
// their paths. Radii: the farthest corner.
void bound_quads(const VertexRow& upper, const VertexRow& lower, int ends, int quads,
                 BlockRow& out);
// Spreads single quads over the blocks of the last level, more than quads, between empty ones.
void spread_quads(const BlockRow& row, int quads, int blocks, BlockRow& out);
// A row of parents from the rows of their children, each of two neighbours when u is split. Radii:
// what the children's spheres demand, at most the half diagonal.
void merge_rows(const BlockRow& upper, const BlockRow& lower, bool split_u, int blocks,
                BlockRow& out);

}  // namespace weft::bsi
