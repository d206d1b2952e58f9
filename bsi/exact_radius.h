// The farthest vertex of a block, for exact radii.
#pragma once

#include "bsi/sphere_build.h"

namespace weft::bsi {

// At most so many blocks of the last level along an axis: their vertices are visited rather than
// their spheres.
inline constexpr int visited_log = 3;

// Square of the largest distance in float32 from the centre to a float32 vertex of a block; never
// less than `squared`. The spheres of the levels below must be built, with exact radii. Descends
// only into blocks that may hold a farther vertex than the farthest one found, which for most
// blocks is one of the corners: O(levels) spheres and a few of the smallest blocks, on a smooth
// surface.
float squared_reach(const SphereTree& tree, const SphereVertices& vertices, int patch, int level,
                    int u, int v, const float* centre, float squared);

}  // namespace weft::bsi
