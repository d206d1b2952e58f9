// The parts of surfaces that are on the wrong side of a surface which they cross.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/view/crossings.h"

namespace weft::sim {

// A part of a body that lines of intersection cut off from the rest of the body, which is larger.
struct CutOffPart {
  int body = 0;  // index into Scene::bodies
  int other =
      0;  // the body whose surface cuts the part off; the same index for one that cuts itself
  std::vector<int> points;  // all points of the part, ascending
  // Points of the body just beyond the cut, as many as edges are cut, and the triangles of `other`
  // that cut them.
  std::vector<int> points_beyond, cutting_triangles;
};

// Returns the parts that lines of intersection cut off. `near` has all pairs of triangles that may
// cross. An edge is cut by the triangles that it meets; one that is cut an even number of times
// joins its ends. Of the parts into which a connected surface falls, the one with the most points
// is the surface, and the others are cut off. A part that several bodies cut off is listed for
// each.
//
// Both spans are all points of the scene (m): `points` are the ends of the edges, `wider` the
// corners of the triangles that cut them. Borders that are wider there let a line of intersection
// go on to the border of the other surface. No edge may end on a triangle, nor pass through an edge
// of one. Sorted by size, then by body. O(points + pairs).
std::vector<CutOffPart> find_cut_off_parts(const Scene& scene, std::span<const Vec3> points,
                                           std::span<const Vec3> wider,
                                           std::span<const Crossing> near);

}  // namespace weft::sim
