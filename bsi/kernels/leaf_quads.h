// The quads of a leaf block and the indices of its leaves. For kernel files only, like box_lanes.h.
#pragma once

#include "bsi/detail/box_layout.h"

namespace weft::bsi::WEFT_KERNELS {

// The quads of a leaf block: first row, first column, number of rows, number of columns.
struct LeafQuads {
  int row, col, rows, cols;
};

static inline int boundary(int k, int count, int log) {
  return static_cast<int>((static_cast<std::int64_t>(k) * count) >> log);
}

static inline LeafQuads quads_of(const BoxTree& tree, BoxNode node) {
  const BoxLevel& level = tree.levels[node.level];
  const BoxPatch& patch = tree.patches[level.patch];
  LeafQuads quads;
  quads.row = boundary(node.v, patch.quad_rows, level.log_v);
  quads.rows = boundary(node.v + 1, patch.quad_rows, level.log_v) - quads.row;
  quads.col = boundary(node.u, patch.quad_cols, level.log_u);
  quads.cols = boundary(node.u + 1, patch.quad_cols, level.log_u) - quads.col;
  return quads;
}

// Writes the indices of a block's leaves to number[0 .. 7], in the order of lanes. Entries of lanes
// without a leaf have no meaning.
static inline void number_leaves(const BoxTree& tree, BoxNode node, bool triangles, int number[8]) {
  const BoxPatch& patch = tree.patches[tree.levels[node.level].patch];
  const LeafQuads quads = quads_of(tree, node);
  typedef int Numbers __attribute__((vector_size(32)));
  constexpr Numbers column = {0, 1, 0, 1, 0, 1, 0, 1}, row = {0, 0, 1, 1, 0, 0, 1, 1};
  constexpr Numbers second = {0, 0, 0, 0, 1, 1, 1, 1};
  const int first = patch.first_quad + quads.row * patch.quad_cols + quads.col;
  const Numbers quad = first + row * patch.quad_cols + column;
  const Numbers all = triangles ? 2 * quad + second : quad;
  __builtin_memcpy(number, &all, sizeof(all));
}

}  // namespace weft::bsi::WEFT_KERNELS
