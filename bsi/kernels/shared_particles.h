// Finds the triangles of two leaf blocks that have a common vertex. For kernel files only, like
// box_lanes.h.
#pragma once

#include "bsi/kernels/leaf_blocks.h"

namespace weft::bsi::WEFT_KERNELS {

// A table of lane pairs whose triangles share a vertex of the grid. shared[R + 2][C + 2] is for two
// leaf blocks, the second of which lies R rows and C columns of quads after the first.
struct SharedVertices {
  LanePairs shared[5][5];
};

constexpr SharedVertices find_shared_vertices() {
  // Row and column of each corner in a quad, for its first and its second triangle.
  constexpr int corner[2][3][2] = {{{0, 0}, {0, 1}, {1, 0}}, {{1, 1}, {0, 1}, {1, 0}}};
  SharedVertices table{};
  for (int pair = 0; pair < 25 * 64; ++pair) {
    const int i = pair / 8 % 8, j = pair % 8;
    const int rows = pair / 320 - 2, cols = pair / 64 % 5 - 2;
    for (int corners = 0; corners < 9; ++corners) {
      const int* a = corner[i / 4][corners / 3];
      const int* b = corner[j / 4][corners % 3];
      if (a[0] + i / 2 % 2 == b[0] + j / 2 % 2 + rows && a[1] + i % 2 == b[1] + j % 2 + cols) {
        table.shared[rows + 2][cols + 2] |= LanePairs{1} << (8 * i + j);
      }
    }
  }
  return table;
}

constexpr SharedVertices shared_vertices = find_shared_vertices();

// A leaf block and its quads.
struct PlacedLeaves {
  BoxNode node;
  LeafQuads quads;
};

static void particles_of(const BoxTree& tree, const PlacedLeaves& leaves, int lane,
                         int particle[3]) {
  const BoxPatch& patch = tree.patches[level_of(tree, leaves.node).patch];
  const auto at = [&](int row, int col) {
    row += leaves.quads.row + lane / 2 % 2;
    col += leaves.quads.col + lane % 2;
    if (row == patch.rows) row = 0;
    if (col == patch.cols) col = 0;
    const int texel = patch.first_texel + row * patch.cols + col;
    return tree.texel_to_particle == nullptr ? texel : tree.texel_to_particle[texel];
  };
  particle[0] = lane < 4 ? at(0, 0) : at(1, 1);
  particle[1] = at(0, 1);
  particle[2] = at(1, 0);
}

static bool share_particle(const BoxTree& tree, const PlacedLeaves& a, int lane_a,
                           const PlacedLeaves& b, int lane_b) {
  int of_a[3], of_b[3];
  particles_of(tree, a, lane_a, of_a);
  particles_of(tree, b, lane_b, of_b);
  for (int i : of_a) {
    for (int j : of_b) {
      if (i == j) return true;
    }
  }
  return false;
}

// Pairs of triangles with a common particle, one from each of two leaf blocks, as far as the table
// of shared vertices tells.
struct SharedParticles {
  LanePairs lanes;
  bool look;  // true: the table does not suffice, particles must be compared
};

// Returns the offset (quads) from a to b along an axis. On a wrapped axis it is the shorter of the
// two ways around.
WEFT_INLINE int offset(int a, int b, int quads, bool wraps) {
  const int direct = b - a;
  if (!wraps) return direct;
  if (2 * direct > quads) return direct - quads;
  return 2 * direct < -quads ? direct + quads : direct;
}

WEFT_INLINE SharedParticles shared_particles(const DescentQuery& query, const PlacedLeaves& a,
                                             const PlacedLeaves& b) {
  if (!query.self || !query.triangles) return {0, false};
  const BoxTree& tree = *query.a;
  if (tree.texel_to_particle != nullptr) return {0, true};
  if (a.node.level != b.node.level) return {0, false};  // different patches that are not sewn
  const BoxPatch& patch = tree.patches[level_of(tree, a.node).patch];
  // On a wrapped axis with fewer quads, two blocks may be neighbours on both sides.
  constexpr int short_ring = 8;
  if ((patch.wrap_u != 0 && patch.quad_cols < short_ring) ||
      (patch.wrap_v != 0 && patch.quad_rows < short_ring)) {
    return {0, true};
  }
  const int rows = offset(a.quads.row, b.quads.row, patch.quad_rows, patch.wrap_v != 0);
  const int cols = offset(a.quads.col, b.quads.col, patch.quad_cols, patch.wrap_u != 0);
  if (rows < -2 || rows > 2 || cols < -2 || cols > 2) return {0, false};
  return {shared_vertices.shared[rows + 2][cols + 2], false};
}

static LanePairs without_shared_particles(const BoxTree& tree, const PlacedLeaves& a,
                                          const PlacedLeaves& b, LanePairs near) {
  LanePairs kept = near;
  for (; near != 0; near &= near - 1) {
    const int pair = __builtin_ctzll(near);
    if (share_particle(tree, a, pair / 8, b, pair % 8)) kept &= ~(LanePairs{1} << pair);
  }
  return kept;
}

}  // namespace weft::bsi::WEFT_KERNELS
