// A triangulated surface as one thing: the faces, edges and vertices near a point, with the signs
// that make a sum over them count the surface once, whatever its triangles.
#pragma once

#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "bsi/proximity.h"

namespace weft::bsi {

// A term of the sum: a face, an edge or a vertex, by its closest point to the point asked about.
struct SurfaceTerm {
  int feature = 0;      // a number of its own for each face, edge and vertex of the mesh
  int triangle = 0;     // a triangle of the mesh that holds the closest point
  int coefficient = 0;  // never 0
  Closest closest;      // of (the point, the triangle's corners), as closest_vertex_triangle
};

// For a point x and any function b(d) that vanishes from d = reach on,
//   sum over the terms of coefficient b(distance)
//     = sum over faces b - sum over inner edges b + sum over inner vertices b,
// each by its own distance from x. By layers of b, this is b integrated over the Euler number of
// the open cells within a distance: 1 where they make one disc, so that a plane counts as b(height)
// however it is triangulated, and the point nearest to x always counts once. Features whose closest
// points coincide cancel: over a face one term is left, that face; over a convex ridge the edge or
// the vertex in whose wedge x lies; in a valley two faces less the edge between them. Each term is
// the distance to a convex set, so that the sum is as smooth as b of one distance.
// (Inclusion-exclusion as in Li et al. 2023, "Convergent Incremental Potential Contact",
// section 4.)
class SurfaceTerms {
 public:
  // The mesh must outlive it. O(mesh).
  SurfaceTerms(const Mesh& mesh, int vertex_count);

  // Replaces `terms` by those within `reach` (m, >= 0) of `point`, in an order that depends on
  // `triangles` alone. `triangles`: all that are within reach, each once, in any order. `own`: the
  // vertex of the surface that the point is, or -1; the triangles around it are then no part of the
  // surface, nor among `triangles`. `position`: of the vertices. O(triangles^2) at the worst.
  void find(const Vec3& point, int own, std::span<const int> triangles,
            std::span<const Vec3> position, double reach, std::vector<SurfaceTerm>& terms) const;

 private:
  bool is_inner_edge(int edge, int own) const;
  bool is_inner_vertex(int vertex, int own) const;

  const Mesh& mesh_;
  std::vector<int> first_triangle_;  // by vertex: the first of the triangles around it
  std::vector<char> on_border_;      // by vertex
  std::vector<int> neighbour_start_, neighbours_;  // by vertex, sorted
};

}  // namespace weft::bsi
