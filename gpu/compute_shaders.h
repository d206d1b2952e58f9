// The compute shaders (GLSL 4.50) of the pyramid and the traversals. They are small and few,
// because llvmpipe takes up to seconds to compile one. They use plain loads and stores and atomics
// of 32-bit numbers: no subgroups, no shared memory.
#pragma once

#include <cstdint>
#include <string>

#include "bsi/leaf_pair.h"

namespace weft::gpu::shaders {

inline constexpr std::uint32_t no_map = 0xFFFFFFFF;
inline constexpr std::uint32_t no_child = 0xFFFFFFFF;

// An entry of the table of levels, in the layout of the shaders (std430): one level of one patch,
// or one group of patches, which has one block. The levels of a patch follow each other, its top
// first.
struct Level {
  std::uint32_t first = 0;  // first block
  std::uint32_t log_u = 0, log_v = 0;
  std::uint32_t leaf = 0;  // 1 on the last level of a patch
  std::uint32_t quad_rows = 0, quad_cols = 0;
  std::uint32_t rows = 0, cols = 0;  // of the image
  std::uint32_t first_vertex =
      0;  // first vertex of the body or, if particles are texels, of the patch
  std::uint32_t first_map = 0;  // index in the map from texels to particles, or no_map
  std::uint32_t first_quad = 0, first_texel = 0;  // numbers in the atlas
  std::uint32_t body = 0;
  std::uint32_t first_tangent =
      0;  // index of the bounds of its first block's steps; unused on the last level of a patch
  // Indices in the table of the two children of a group of patches, which are groups or patch tops.
  // They are equal if the group has one child. A level of a patch has no_child.
  std::uint32_t first_child = no_child, second_child = no_child;
};

inline constexpr int group_size = 64;  // invocations per work group

// The task of a run of work groups, found by a group's number: a patch and three of its levels.
// `middle` is the parent of `lowest`, and the top level is the parent of `middle`. Either may also
// be the same level.
struct Task {
  std::uint32_t first_group = 0;  // of this task, in the dispatch
  std::uint32_t lowest = 0, middle = 0;
  std::uint32_t top_and_swept = 0;  // top level; highest bit set: both ends of paths are bounded
};

// Bounds of the steps between the vertices of a block, in the order of bsi::TangentBounds.
struct Tangent {
  float bound[12];
};

// Returns the shader that bounds blocks by boxes. Every invocation bounds one block of the top
// level of its task and the blocks below it on the two lower levels. With `from_image`, the lowest
// level consists of leaf blocks, bounded from the vertices. Otherwise it is already bounded.
std::string bound_boxes();
// Returns the shader that bounds blocks by spheres. Their boxes must already be bounded. Without
// `rounds_like_the_cpu`, radii are slightly larger.
std::string bound_spheres(bool rounds_like_the_cpu);
// Returns the shader that bounds groups of patches by the boxes of their children.
std::string bound_groups();
// Returns the shader that bounds the steps between vertices (bsi::TangentBounds), on all but the
// last levels.
std::string bound_tangents();

// --- Traversal ------------------------------------------------------------------------------

// A query: the criteria by which pairs of blocks are compared.
struct Query {
  double certificate_margin = -1;  // negative: no tangent certificate
  float half_margin = 0;
  std::uint32_t flags = 0;
  float point[3]{};  // with the flag `point`: the centre with which blocks are compared
  float sphere_reach = 0;
  float filter_reach =
      -1;  // m; pairs of quads proved farther apart are left out; negative: none are
  std::uint32_t unused = 0;
};
namespace query_flags {
inline constexpr std::uint32_t self = 1, point = 2, swept_a = 4, swept_b = 8;
}

// A pair of blocks of a query. In a self traversal, a == b pairs a block with itself.
struct BlockPair {
  std::uint32_t a = 0, b = 0;
  std::uint32_t levels = 0;  // indices in the table: a's in the lower 16 bits, b's in the upper
  std::uint32_t query = 0;
};

// A list on the device: its length, and the arguments of the indirect dispatch that reads it.
struct List {
  std::uint32_t groups = 0, one = 1, one_too = 1;
  std::uint32_t length = 0;
};

// Returns the shader that appends the pairs of children within the margin of each other by the
// bounds that `bound` selects. Pairs of leaf blocks go to their own list. With
// `rounds_like_the_cpu`, the tangent certificate decides exactly as on the CPU. Otherwise it
// rejects slightly fewer pairs.
std::string expand_pairs(bsi::Bound bound, bool rounds_like_the_cpu);
// Returns the shader that converts pairs of leaf blocks to pairs of leaves. Its results are query,
// a, b.
std::string find_leaves();

}  // namespace weft::gpu::shaders
