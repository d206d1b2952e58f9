// Light of the sky, shadowed in folds and at contacts. It makes shapes readable.
#pragma once

#include "gpu/triangle_batch.h"

namespace weft::gpu {

// Returns the distance (m) from the origin within which the batch can shadow the sky, at most
// `reach`. Vertices beyond `reach` are ignored. The result changes in steps, hence rarely while
// surfaces move. O(vertices).
double sky_reach(const TriangleBatch& batch, double reach);

// Lights each vertex of the batch on both sides by many lights spread over the sky, with the
// shadows of the batch's triangles. A free level surface receives the value 1. The light varies
// slowly along a surface, so it is computed at vertices and interpolated. Each light casts shadows
// within a square of half side `reach` (m) around the origin. `up` is a unit vector. O(lights *
// (triangles + vertices)).
void add_sky_light(const Vec3& up, double reach, TriangleBatch& batch);

}  // namespace weft::gpu
