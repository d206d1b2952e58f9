// The compute shaders (GLSL 4.50) of the pyramid and the traversals. They are small and few,
// because llvmpipe takes up to seconds to compile one. They access memory by plain loads, plain
// stores and 32-bit atomics, without subgroups or shared memory.
#pragma once

#include <cstdint>
#include <string>

#include "bsi/leaf_pair.h"

namespace weft::gpu::shaders {

inline constexpr std::uint32_t no_map = 0xFFFFFFFF;
inline constexpr std::uint32_t no_child = 0xFFFFFFFF;

// An entry of the table of levels, in the layout of the shaders (std430). It is one level of one
// patch, or one group of patches. A group has one block. The levels of a patch are consecutive,
// from its top down.
struct Level {
  std::uint32_t first = 0;             // index of the first block, counted over all bodies
  std::uint32_t log_u = 0, log_v = 0;  // the level has 2^log_u x 2^log_v blocks
  std::uint32_t leaf = 0;              // 1 on the last level of a patch
  std::uint32_t quad_rows = 0, quad_cols = 0;
  std::uint32_t rows = 0, cols = 0;  // size of the patch's image, texels
  // Index of the body's first vertex or, if the body's texels are its particles, of the patch's
  // first vertex.
  std::uint32_t first_vertex = 0;
  // Index of the patch's first texel in the map of texels to particles, or no_map.
  std::uint32_t first_map = 0;
  std::uint32_t first_quad = 0, first_texel = 0;  // first quad and texel in the atlas
  std::uint32_t body = 0;
  // Index of the first block's Tangent. Unused on the last level of a patch and for a group.
  std::uint32_t first_tangent = 0;
  // For a group: indices of its two children in the table. Each child is a group or the top level
  // of a patch. Both indices are equal if the group has only one patch. A level of a patch has
  // no_child.
  std::uint32_t first_child = no_child, second_child = no_child;
};

inline constexpr int group_size = 64;  // invocations per work group

// A task for consecutive work groups of a dispatch: to bound up to three consecutive levels of a
// patch, named by their indices in the table. If the patch has fewer levels above `lowest`, two or
// three of the indices are equal.
struct Task {
  std::uint32_t first_group = 0;  // index of the task's first work group in the dispatch
  std::uint32_t lowest = 0, middle = 0;
  std::uint32_t top_and_swept = 0;  // the top level; the highest bit is set for swept bodies
};

// Bounds of the steps between the vertices of a block, in the order of bsi::TangentBounds.
struct Tangent {
  float bound[12];
};

// Returns the shader that bounds blocks by boxes. An invocation bounds one block of the top level
// of its task and the blocks below it on the lower levels of the task. If the uniform `from_image`
// is 1, the lowest level consists of leaf blocks, which are bounded from the vertices. If it is 0,
// the lowest level is already bounded.
std::string bound_boxes();
// Returns the shader that bounds blocks by spheres. Their boxes must already be bounded. Without
// `rounds_like_the_cpu`, radii are slightly larger.
std::string bound_spheres(bool rounds_like_the_cpu);
// Returns the shader that bounds groups of patches by the boxes of their children.
std::string bound_groups();
// Returns the shader that bounds the steps between vertices (bsi::TangentBounds), on all levels of
// a patch except the last.
std::string bound_tangents();

// --- Traversal ------------------------------------------------------------------------------

// A query: the criteria by which pairs of blocks are compared.
struct Query {
  double certificate_margin = -1;  // m; negative: no tangent certificate
  float half_margin = 0;           // m
  std::uint32_t flags = 0;
  float point[3]{};        // centre of the ball (m), for queries with the flag `point`
  float sphere_reach = 0;  // m
  // Distance (m) that a plane must prove, in addition to the quads' motion, to skip a pair of
  // quads. Negative: planes are not tested.
  float filter_reach = -1;
  std::uint32_t unused = 0;
};
namespace query_flags {
inline constexpr std::uint32_t self = 1, point = 2, swept_a = 4, swept_b = 8;
}

// A pair of blocks to compare for a query. In a self traversal, a == b pairs a block with itself.
// In the query of a ball, `a` is the number of the query.
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

// Returns the shader that reads pairs of blocks and appends those pairs of their children that are
// near each other by the bounds that `bound` selects. Boxes alone decide for the children of a pair
// that contains a group. Pairs of leaf blocks go to a list of their own. With
// `rounds_like_the_cpu`, the tangent certificate decides exactly as on the CPU. Otherwise it may
// reject fewer pairs.
std::string expand_pairs(bsi::Bound bound, bool rounds_like_the_cpu);
// Returns the shader that converts pairs of leaf blocks to pairs of leaves. Each result is three
// numbers: query, a, b.
std::string find_leaves();

}  // namespace weft::gpu::shaders
