// Neighbours at rest across seams: parts of sewn surfaces that are near each other along them.
#pragma once

#include <map>
#include <vector>

#include "sim/contact/contact_search.h"

namespace weft::sim {

// Triangles of one body by vertex of another one, or of the same one; sorted.
using TrianglesByVertex = std::vector<std::vector<int>>;

// Returns the neighbours across the seams of a scene, by the bodies of the vertex and of its
// triangles. A triangle is a neighbour if a path at rest that crosses seams leads to it from the
// vertex within R = pi/2 thickness + range (m), where thickness is the mean of both bodies. The
// rest shapes of two pieces have no common place, so the length of a path is the sum of its
// straight parts within each piece.
//
// Seams are crossed at their stitches. A path that crosses between two stitches is shorter than the
// one through the nearer stitch by the distance of the stitches at most, so that the triangles
// within R and this distance more are taken.
//
// Two bodies have neighbours only if a triangle comes within thickness + range of a vertex to which
// it is not sewn: on coarser meshes, sewn points are all that contact must leave alone. O(stitches
// x triangles within R of a stitch), for each vertex within R of a seam.
std::map<BodyPair, TrianglesByVertex> neighbours_across_seams(const Scene& scene, double range);

}  // namespace weft::sim
