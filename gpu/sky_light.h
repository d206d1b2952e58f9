// Light of the sky, shadowed in folds and at contacts. It makes shapes readable.
#pragma once

#include "gpu/triangle_batch.h"

namespace weft::gpu {

// Returns the half side (m) of the shadow maps for add_sky_light(): at most `reach`, and at least
// the distance from the origin to the farthest vertex within `reach`. The result has discrete
// values, so it rarely changes while surfaces move. O(vertices).
double sky_reach(const TriangleBatch& batch, double reach);

// Lights each vertex of the batch on both sides by many lights spread over the sky, with the
// shadows of the batch's triangles. The upper side of a horizontal surface without shadows receives
// the value 1. The light varies slowly along a surface, so it is computed at vertices and
// interpolated. Each light casts shadows within a square of half side `reach` (m) around the
// origin. `up` is a unit vector. O(lights * (triangles + vertices + texels covered)).
void add_sky_light(const Vec3& up, double reach, TriangleBatch& batch);

}  // namespace weft::gpu
