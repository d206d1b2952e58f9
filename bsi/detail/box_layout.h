// The memory layout of a box pyramid: plain structures for the kernels that build and descend it.
// An internal header of bsi/; it must stay free of inline functions (see
// bsi/detail/instruction_set.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace weft::bsi {

// The boxes (m) of the four children of a block, one array per bound and axis. Child 2 j + i is in
// column i and row j of the 2 x 2 children. If u is not split, the children of column 1 are absent;
// if v is not split, those of row 1. The box of an absent child has low > high.
struct alignas(32) BoxGroup {
  float low[3][4];
  float high[3][4];
};

// The spheres (m) of the four children of a block, one array per component. The centre of an absent
// child is NaN, so that the child touches no sphere.
struct alignas(64) SphereGroup {
  float centre[3][4];
  float radius[4];
};

// Bounds (m) of the steps, the differences between adjacent vertices of a block: along u (x, y, z),
// then along v. Lower bounds are negated, so that a union is a maximum.
struct alignas(64) TangentBounds {
  float bound[16];  // 6 negated lower bounds, 6 upper bounds, 4 unused
};

// Rows of float32 vertices, one array per component, m. Rows are `stride` floats apart. On a
// wrapped axis, copies of the first vertices follow the last ones. At least four floats past the
// end of each row are readable.
struct VertexImage {
  const float* component[3];
  std::size_t stride;
};

// One level of a patch. The last level holds the leaf blocks, of up to 2 x 2 quads.
struct BoxLevel {
  const BoxGroup* groups;         // boxes of each block's children; null on the last level
  const TangentBounds* tangents;  // bounds of each block's steps; null if not stored
  const SphereGroup* spheres;     // spheres of each block's children; null if not stored
  std::int32_t log_u, log_v;      // the level has 2^log_u x 2^log_v blocks
  std::int32_t split_u, split_v;  // 1 where the next level halves the axis, else 0
  std::int32_t patch;             // index in BoxTree::patches
};

struct BoxPatch {
  VertexImage vertices[2];  // at the start and the end of the paths; the end only if swept
  float low[3], high[3];    // box of the whole patch, m
  float centre[3], radius;  // sphere of the whole patch, m, if spheres are stored
  std::int32_t quad_rows, quad_cols;
  std::int32_t wrap_u, wrap_v;  // 1 for a wrapped axis, else 0
  std::int32_t first_level;     // index in BoxTree::levels
  std::int32_t level_count;
  std::int32_t first_quad;   // index of the first quad in the atlas
  std::int32_t first_texel;  // index of the first texel in the atlas
  std::int32_t rows, cols;   // numbers of rows and columns of texels
};

// The placement in space of a tree that was built in the frame of a rigid body. Point p of the
// frame is at R p + t in space. A path has such a placement at each end.
struct BoxPlacement {
  const double* positions;        // x, y and z of every particle in the frame, m
  double rotation[2][3][3];       // R at each end, by row and column
  double translation[2][3];       // t at each end, m
  float rotation_float[2][3][3];  // `rotation`, rounded to float32
  float translation_float[2][3];  // `translation`, rounded to float32
  float rounding;                 // upper bound of the float32 rounding of a placed box, m
};

// The data of a pyramid that a descent reads.
struct BoxTree {
  const BoxLevel* levels;
  const BoxPatch* patches;
  const std::int32_t* texel_to_particle;  // particle of each texel; null if texel i is particle i
  const BoxPlacement* placement;          // null if the tree was built in space
  std::int32_t swept;                     // 1 if vertices move along paths, else 0
  float magnitude;                        // upper bound of the vertices' |coordinates|, m
};

// Upper bound of the square root of 3, the largest ratio of a vector's length to its largest
// component.
inline constexpr float root_of_three = 1.7320511F;

// A block: its level (index in BoxTree::levels), and its column u and row v on that level.
struct BoxNode {
  std::int32_t level;
  std::uint16_t u, v;
};

}  // namespace weft::bsi
