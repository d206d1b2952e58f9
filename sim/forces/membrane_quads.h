// Sums over the two triangles of a quad, for membranes.
#pragma once

#include "materials/membrane.h"
#include "sim/forces/quads.h"
#include "sim/forces/stencil_array.h"

namespace weft::sim {

using MembraneCorners = materials::NodesOf<materials::Lanes, 4>;
using MembraneStencils = StencilArray<4, QuadCorners>;
using QuadBlocks = materials::StencilMatrix<materials::Lanes, 4>;
using TriangleBlocks = materials::StencilMatrix<materials::Lanes, 3>;

// Returns the sum of the forces of both triangles on the corners of their quad.
inline MembraneCorners sum_of(const materials::NodesOf<materials::Lanes, 3>& one,
                              const materials::NodesOf<materials::Lanes, 3>& other) {
  MembraneCorners sum;
  sum.col(0) = one.col(0);
  sum.col(1) = one.col(1) + other.col(0);
  sum.col(2) = one.col(2) + other.col(2);
  sum.col(3) = other.col(1);
  return sum;
}

// Adds the blocks of triangle t to the blocks of its quad.
inline void add_triangle(const TriangleBlocks& triangle, int t, QuadBlocks& quad) {
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      const int row = corners_of[t][a], column = corners_of[t][b];
      if (row <= column) {
        quad(row, column) += triangle(a, b);
      } else {
        quad(column, row) += triangle(a, b).transpose();
      }
    }
  }
}

// Adds the stiffness due to the edge tensions of triangle t (N/m) to the blocks of its quad.
// `pull_only` leaves out edges under compression.
inline void add_stress(const materials::Vec3Of<materials::Lanes>& tensions, bool pull_only, int t,
                       QuadBlocks& quad) {
  TriangleBlocks stress;
  stress.blocks.fill(materials::Mat3Of<materials::Lanes>::Zero());
  materials::add_membrane_stress(tensions, pull_only, stress);
  add_triangle(stress, t, quad);
}

// Calls visit(quad, corners, rest) for each quad of a body. `corners` are global indices of
// particles, and `rest` has the rest positions (m) of the nodes of both triangles.
template <class Visit>
void for_each_quad(const SceneBody& body, const Visit& visit) {
  for (int q = 0; q < quad_count(body); ++q) {
    const Quad corners = quad_corners(body, q);
    materials::Nodes4 rest;
    Quad global = corners;
    for (int i = 0; i < 4; ++i) {
      rest.col(i) = body.rest[corners[i]];
      global[i] += body.first_particle;
    }
    visit(q, global, std::array{triangle_nodes(rest, 0), triangle_nodes(rest, 1)});
  }
}

}  // namespace weft::sim
