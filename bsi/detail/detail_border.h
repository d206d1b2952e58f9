// Selects the vertices on the borders of patches that a surface of reduced detail keeps.
#pragma once

#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// Returns, for each patch, 1 if all its texels must keep their own vertices, else 0. They must if
// the patch has no inner texels, wraps fewer than five quads or is sewn to itself.
std::vector<char> patches_left_alone(const Atlas& atlas);

// Returns, for every particle, the particle that replaces it on the borders of patches, or itself.
// A border is cut into stretches at the corners of patches, and where other patches begin or end.
// The ends of a stretch are kept. Patches that share a stretch also share its samples. A stretch
// has one part per block along it of the patch with the finest blocks. It has more parts if two
// stretches would otherwise become the same edge.
//
// `levels` is by patch; beyond its last level a patch keeps every vertex. `left_alone` is the
// result of patches_left_alone(). O(n log n) for n particles.
std::vector<int> sampled_borders(const Pyramid& pyramid, std::span<const int> levels,
                                 std::span<const char> left_alone);

}  // namespace weft::bsi
