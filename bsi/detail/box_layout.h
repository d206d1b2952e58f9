// The memory layout of a box pyramid: plain structures for the kernels that build and descend it.
// An internal header of bsi/; it must stay free of inline functions (see
// bsi/detail/instruction_set.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace weft::bsi {

// The boxes of the four children of a block, one array per bound and axis. Child 2 j + i is at
// column i and row j of the 2 x 2. A child that is absent because its axis is not split has low >
// high.
struct alignas(32) BoxGroup {
  float low[3][4];
  float high[3][4];
};

// The spheres of the four children of a block, one array per component. An absent child has NaN as
// its centre, so that every comparison with it is false.
struct alignas(64) SphereGroup {
  float centre[3][4];
  float radius[4];
};

// Bounds of the steps (differences) between neighbouring vertices of a block: along u (x, y, z),
// then along v. Lower bounds are negated, so that a union is a maximum.
struct alignas(64) TangentBounds {
  float bound[16];  // 6 lower ones, negated, 6 upper ones, 4 unused
};

// Rows of float32 vertices, one array per component, m. A wrapped axis is closed by a copy of its
// first vertices. Four floats past the end of any row may be read.
struct VertexImage {
  const float* component[3];
  std::size_t stride;
};

// One level of a patch. The last level holds the leaf blocks, of up to 2 x 2 quads.
struct BoxLevel {
  const BoxGroup* groups;         // one per block: its children's boxes; null on the last level
  const TangentBounds* tangents;  // one per block; null if the level has none
  const SphereGroup* spheres;     // one per block: its children's spheres; null if there are none
  std::int32_t log_u, log_v;      // 2^log_u x 2^log_v blocks
  std::int32_t split_u, split_v;  // 1 where the next level halves the axis, else 0
  std::int32_t patch;
};

struct BoxPatch {
  VertexImage vertices[2];  // at both ends of the paths; equal unless swept
  float low[3], high[3];    // box of the whole patch
  float centre[3], radius;  // of the patch's sphere, if there are spheres
  std::int32_t quad_rows, quad_cols;
  std::int32_t wrap_u, wrap_v;  // 1 or 0
  std::int32_t first_level;     // index in BoxTree::levels
  std::int32_t level_count;
  std::int32_t first_quad;  // numbers in the atlas
  std::int32_t first_texel;
  std::int32_t rows, cols;  // of the image
};

// The placement in space of a tree that was built in the frame of a rigid body. Point p of the
// frame is at R p + t, at one or both ends of its path.
struct BoxPlacement {
  const double* positions;        // x, y and z of every particle in the frame, m
  double rotation[2][3][3];       // by end, row and column
  double translation[2][3];       // by end, m
  float rotation_float[2][3][3];  // rotation, rounded
  float translation_float[2][3];
  float rounding;  // m, bound of a placed box's float32 rounding (rigid_pyramid.cpp)
};

// All data that a descent reads.
struct BoxTree {
  const BoxLevel* levels;
  const BoxPatch* patches;
  const std::int32_t* texel_to_particle;  // null: particle i is texel i
  const BoxPlacement* placement;          // null: the tree was built in space
  std::int32_t swept;                     // 1 or 0
  float magnitude;                        // the largest |coordinate| of a vertex, m
};

// Upper bound of the square root of 3, the largest ratio of a distance to its largest component.
inline constexpr float root_of_three = 1.7320511F;

// A block: its level, numbered through all patches, and its column u and row v on that level.
struct BoxNode {
  std::int32_t level;
  std::uint16_t u, v;
};

}  // namespace weft::bsi
