// The loops that build a sphere pyramid, one table for each instruction set. An internal header of
// bsi/; it must stay free of inline functions (see instruction_set.h).
//
// Rows are arrays of floats with room for row_padding more than they hold: the loops run over whole
// vectors, and what lies beyond the end is read and written, but never counts.
#pragma once

#include <cstddef>
#include <cstdint>

namespace weft::bsi {

// The widest vector, and the shift by one vertex.
inline constexpr int row_padding = 32;

// A row of blocks: bounds of the vertices by axis, and twice the radius (-infinity for a block
// without quads, whose box is one of the vertices of its neighbours).
struct SphereRow {
  float* low[3];
  float* high[3];
  float* diameter;
};

// A row of float32 vertices, by component.
struct SphereVertexRow {
  const float* component[3];
};

// Two or three rows of vertices at one or both ends of their paths: rows[end][row].
struct SphereVertexRows {
  SphereVertexRow row[2][3];
  std::int32_t row_count;
  std::int32_t ends;
};

// Spheres are written as four floats each: centre, radius.
struct SphereKernels {
  // Copies entries of a row, by runs: run k, of `length[k]` entries from `from[k]` on, follows run
  // k - 1. The rows must not overlap.
  void (*copy_runs)(const float* row, const std::int32_t* from, const std::int32_t* length,
                    int runs, float* out);
  // One or two rows of blocks of one quad, whose radii are those of the farthest corner.
  void (*bound_quads)(const SphereVertexRows& rows, int blocks, const SphereRow* out,
                      float* const* spheres);
  // The spheres of the two triangles of every quad between two rows, 2 * blocks.
  void (*bound_triangles)(const SphereVertexRows& rows, int blocks, float* spheres);
  // Parents from two rows of children (the same twice where v is not split), with radii that
  // reach around the children, at most half the diagonal.
  void (*merge)(const SphereRow& upper, const SphereRow& lower, bool split_u, int blocks,
                const SphereRow& out, float* spheres);
  // The same without radii and spheres.
  void (*merge_boxes)(const SphereRow& upper, const SphereRow& lower, bool split_u, int blocks,
                      const SphereRow& out);
  // Centres of blocks of 2^log columns each, repeated for each column. log <= 3.
  void (*spread_centres)(const SphereRow& row, int log, int columns, float* const centre[3]);
  // squared[i] becomes at least the squared distance of vertices i and i + 1 from centre i.
  void (*reach)(const SphereVertexRow& row, const float* const centre[3], int columns,
                float* squared);
  // Maxima of 2^log neighbours each, in place. log <= 3.
  void (*fold)(int log, int blocks, float* squared);
  // Diameters and spheres from boxes and squared distances.
  void (*cover)(const float* squared, int blocks, const SphereRow& row, float* spheres);
  // The largest squared distance from a centre of vertices [begin, begin + columns] of several
  // rows, columns <= 8; never less than `squared`.
  float (*reach_of_block)(const SphereVertexRow* rows, int row_count, int begin, int columns,
                          const float* centre, float squared);
  // How far spheres reach from a centre: `columns` of them a row, rows `stride` floats apart. Those
  // with a negative radius count for nothing; -1 where there is no other.
  float (*reach_of_spheres)(const float* spheres, std::size_t stride, int rows, int columns,
                            const float* centre);
};

// Of instruction_set().
const SphereKernels& sphere_kernels();

}  // namespace weft::bsi
