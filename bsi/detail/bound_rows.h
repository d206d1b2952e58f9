// Rows of vertices and of bounds while a pyramid is built: plain structures for Pyramid and its
// kernels. An internal header of bsi/; it must stay free of inline functions (see
// bsi/detail/instruction_set.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace weft::bsi {

// A row of blocks while the pyramid is built: 18 planes with one float per block, `stride` apart.
// Planes 0-5 bound the vertices, planes 6-17 the steps between them (TangentBounds::bound). Lower
// bounds are negated, so that every union is a maximum. Kernels may read and write a plane up to a
// multiple of plane_padding blocks, and may read one float more.
inline constexpr int plane_count = 18;
inline constexpr int plane_padding = 16;
struct BoundRow {
  float* plane;
  std::size_t stride;
};

// Two to five consecutive rows of vertices.
struct VertexRows {
  const float* row[5][3];  // by row and component
  std::int32_t count;      // 2 to 5
};

}  // namespace weft::bsi
