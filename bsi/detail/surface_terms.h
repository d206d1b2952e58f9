// The faces, edges and vertices of a triangulated surface near a point. Their signs make a sum over
// them count the surface once, whatever its triangles.
#pragma once

#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "bsi/proximity.h"

namespace weft::bsi {

// A term of the sum: a face, an edge or a vertex, with its closest point to the given point.
struct SurfaceTerm {
  int feature = 0;      // unique among the faces, edges and vertices of the mesh
  int triangle = 0;     // a triangle of the mesh that contains the closest point
  int coefficient = 0;  // never 0
  Closest closest;      // of (the point, the triangle's corners), see closest_vertex_triangle
};

// For a point x and any function b(d) that is 0 for d >= reach,
//   sum over the terms of coefficient b(distance)
//     = sum over faces b - sum over inner edges b + sum over inner vertices b,
// where each feature counts with its own distance from x. The sum is the integral of -b'(s) chi(s)
// ds, where chi(s) is the Euler number of the open cells within the distance s. chi is 1 if these
// cells form one disc: a plane counts as b(height) however it is triangulated, and the nearest
// point always counts once. Features whose closest points coincide cancel. Over a face one term
// remains, that face. Over a convex ridge it is the edge or vertex in whose wedge x lies; in a
// valley, two faces less the edge between them. Each term is the distance to a convex set, so the
// sum is as smooth as b of a single distance. (Inclusion-exclusion as in Li et al. 2023,
// "Convergent Incremental Potential Contact", section 4.)
class SurfaceTerms {
 public:
  // The mesh must outlive the object. O(mesh).
  SurfaceTerms(const Mesh& mesh, int vertex_count);

  // Replaces `terms` by those within `reach` (m, >= 0) of `point`, in an order that depends only on
  // `triangles`. These list every triangle within reach once, in any order. If the point is a
  // vertex of this mesh, `own` is its number, else -1. Triangles around `own` do not count and must
  // not be listed. `position` is by vertex, m. O(triangles^2) in the worst case.
  void find(const Vec3& point, int own, std::span<const int> triangles,
            std::span<const Vec3> position, double reach, std::vector<SurfaceTerm>& terms) const;

 private:
  bool is_inner_edge(int edge, int own) const;
  bool is_inner_vertex(int vertex, int own) const;

  const Mesh& mesh_;
  std::vector<int> first_triangle_;                // by vertex: the first triangle around it
  std::vector<char> on_border_;                    // by vertex
  std::vector<int> neighbour_start_, neighbours_;  // by vertex, sorted
};

}  // namespace weft::bsi
