// Rows of vertices and of bounds while a pyramid is built: plain structures for Pyramid and its
// kernels. An internal header of bsi/; it must stay free of inline functions (see
// bsi/detail/instruction_set.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace weft::bsi {

// Number of planes of a BoundRow.
inline constexpr int plane_count = 18;
// Kernels may write a plane up to the next multiple of this number of blocks. They may read it up
// to the next multiple of twice this number, and one float more.
inline constexpr int plane_padding = 16;
// A row of blocks while the pyramid is built: 18 planes with one float per block, `stride` floats
// apart. Planes 0-5 bound the vertices, planes 6-17 the steps between them (in the order of
// TangentBounds::bound). Lower bounds are negated, so that every union is a maximum.
struct BoundRow {
  float* plane;
  std::size_t stride;
};

// One to five consecutive rows of float32 vertices.
struct VertexRows {
  const float* row[5][3];  // vertices of each row, by component, m
  std::int32_t count;      // number of rows
};

}  // namespace weft::bsi
