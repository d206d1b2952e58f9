// The check of the places at which spheres start.
#pragma once

#include "sim/scene/scene.h"

namespace weft::sim {

// Throws CaseError, placed at the positions of the later group, if a sphere overlaps another sphere
// or the surface of an obstacle, less half its thickness, at t = 0. The message names the first
// pair and the number of pairs.
void refuse_overlapping_spheres(const Scene& scene);

}  // namespace weft::sim
