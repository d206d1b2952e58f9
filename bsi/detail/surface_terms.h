// The faces, edges and vertices of a triangulated surface near a point, with signed integer
// coefficients. A sum with these coefficients counts the surface once, however it is triangulated.
#pragma once

#include <span>
#include <vector>

#include "bsi/detail/neighbourhoods.h"
#include "bsi/geometry_image.h"
#include "bsi/proximity.h"

namespace weft::bsi {

// A term of the sum: a face, an edge or a vertex of the mesh, with its point closest to the given
// point.
struct SurfaceTerm {
  int feature = 0;      // identifier of the face, edge or vertex in the mesh
  int triangle = 0;     // a triangle of the mesh that contains the closest point
  int coefficient = 0;  // coefficient in the sum, never 0
  Closest closest;      // closest point of the feature; weights are for the corners of `triangle`
};

// The terms of a signed sum over the features of a surface. Let x be a point and b(d) any function
// that is 0 for d >= reach. Then
//   sum over the terms of coefficient b(distance)
//     = sum over faces b - sum over inner edges b + sum over inner vertices b,
// where every feature has its own distance from x. The sum is the integral of -b'(s) chi(s) ds,
// where chi(s) is the Euler characteristic of the open cells within the distance s. Where these
// cells form one disc, chi is 1. A plane therefore counts as b(height), however it is triangulated.
//
// Features with the same closest point form one term, and their coefficients are added up. Terms
// with coefficient 0 are dropped. Over a face of a flat or convex surface, only the term of that
// face remains. Over a convex ridge, the remaining term is the edge or vertex in whose wedge x
// lies. In a valley, the terms of two faces remain, less that of the edge between them. Each term
// is b of the distance to a convex set, so the sum is as smooth as b of a single distance.
// (Inclusion-exclusion as in Li et al. 2023, "Convergent Incremental Potential Contact",
// section 4.)
class SurfaceTerms {
 public:
  // The mesh must outlive the object, and so must the neighbourhoods of its vertices, if any.
  // O(mesh).
  SurfaceTerms(const Mesh& mesh, int vertex_count, const Neighbourhoods* neighbourhoods = nullptr);

  // Replaces `terms` by the terms within `reach` (m, >= 0) of `point`. `triangles` lists every
  // triangle within reach exactly once, in any order. `own` is the index of the point in this mesh,
  // or -1 if the point is not a vertex of it. Triangles with the vertex `own` do not count and must
  // not be listed, and neither must other triangles of its neighbourhood. Edges and vertices on the
  // rim of what is left out count as those of the border. `position` is by vertex, m. With
  // `across`, `own` is the index of the point in another mesh, and `across` has the neighbourhoods
  // of that mesh's vertices in this one. O(triangles^2) in the worst case.
  void find(const Vec3& point, int own, std::span<const int> triangles,
            std::span<const Vec3> position, double reach, std::vector<SurfaceTerm>& terms,
            const Neighbourhoods* across = nullptr) const;
  // Returns which edges and corners have terms that find() adds together with that of a listed
  // triangle. Bit k stands for the edge opposite corner k, bit 3 + k for corner k. Each inner edge
  // and each inner vertex belongs to one of its triangles.
  unsigned own_features(int triangle, int own, const Neighbourhoods* across = nullptr) const;

 private:
  void find_own_features();
  // Return true if an inner edge or an inner vertex is at the rim of what is left out around the
  // vertex `own`.
  bool is_beside(const Edge& edge, int own, const Neighbourhoods* near) const;
  bool is_beside(int vertex, int own, const Neighbourhoods* near) const;

  const Mesh& mesh_;
  const Neighbourhoods* neighbourhoods_;  // null: only triangles with the vertex itself
  std::vector<char> on_border_;           // 1 for each vertex on the border, else 0
  // Sorted neighbours of each vertex, in compressed rows.
  std::vector<int> neighbour_start_, neighbours_;
  std::vector<unsigned> own_features_;  // by triangle: own_features() for points of other meshes
};

}  // namespace weft::bsi
