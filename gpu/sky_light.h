// The light of the sky, shadowed in folds and at contacts, which makes shapes readable.
#pragma once

#include "gpu/triangle_batch.h"

namespace weft::gpu {

// Returns the distance (m) from the origin within which the batch can shadow the sky, at most
// `reach`; vertices beyond that are ignored. It changes in steps, hence rarely while surfaces move.
// O(vertices).
double sky_reach(const TriangleBatch& batch, double reach);

// Lights each vertex of the batch on both sides by many lights spread over the sky, with the
// shadows of the batch's triangles. The value 1 is what a free level surface receives. The light
// varies slowly along a surface, so it is computed at vertices and interpolated. Shadows reach no
// farther from the origin than `reach` (m); `up` is unit. O(lights * (triangles + vertices)).
void add_sky_light(const Vec3& up, double reach, TriangleBatch& batch);

}  // namespace weft::gpu
