// The compute shaders (GLSL 4.50) of the pyramid and the traversals. Small, and few: llvmpipe takes
// up to seconds to compile one. Plain loads and stores of 32-bit numbers and atomics on them: no
// subgroups, no shared memory.
#pragma once

#include <cstdint>
#include <string>

namespace weft::gpu::shaders {

// One level of one patch, as the shaders see it (std430). Levels of a patch follow each other, the
// patch top first.
struct Level {
  std::uint32_t first = 0;  // block
  std::uint32_t log_u = 0, log_v = 0;
  std::uint32_t leaf = 0;  // 1 on the last level of a patch
  std::uint32_t quad_rows = 0, quad_cols = 0;
  std::uint32_t rows = 0, cols = 0;  // of the image
  std::uint32_t first_vertex =
      0;                        // of the body's particles; of the patch's, where particle == texel
  std::uint32_t first_map = 0;  // into the map from texels to particles, or no_map
  std::uint32_t first_quad = 0, first_texel = 0;  // in the atlas' numbers
  std::uint32_t body = 0;
  std::uint32_t unused[3]{};
};
inline constexpr std::uint32_t no_map = 0xFFFFFFFF;

inline constexpr int group_size = 64;  // invocations a work group

// What a work group looks up by its number: a patch and three of its levels, each the next one's
// parents or the same.
struct Task {
  std::uint32_t first_group = 0;  // of the dispatch
  std::uint32_t lowest = 0, middle = 0;
  std::uint32_t top_and_swept = 0;  // the highest bit: at both ends of the paths
};

// Every invocation bounds the blocks of three levels that lie under one block of the top one, that
// included. `from_image`: the lowest level, of leaf blocks, is made from the vertices; otherwise it
// is there.
std::string bound_boxes();
// The same for spheres, where the boxes are there.
std::string bound_spheres();

}  // namespace weft::gpu::shaders
