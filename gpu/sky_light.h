// The light of the sky, which folds and contacts keep off: it makes shapes readable.
#pragma once

#include "gpu/triangle_batch.h"

namespace weft::gpu {

// Returns the distance from the origin within which the batch can keep off the light of the sky, at
// most `reach`; vertices beyond that are left out. It goes in steps, so that it seldom changes
// while things move. O(vertices).
double sky_reach(const TriangleBatch& batch, double reach);

// Lights each vertex of the batch on both sides by many lights spread over the sky, with the
// shadows of the batch's triangles. One is what a free level surface receives. The light changes
// slowly along a surface, so it is found at vertices and interpolated. Shadows reach no farther
// from the origin than `reach` (m); `up` is unit. O(lights * (triangles + vertices)).
void add_sky_light(const Vec3& up, double reach, TriangleBatch& batch);

}  // namespace weft::gpu
