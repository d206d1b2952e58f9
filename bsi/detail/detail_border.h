// Selects the vertices on the borders of patches that a surface of reduced detail keeps.
#pragma once

#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// Returns, for each patch, 1 if all its texels must keep their own vertices, else 0. They must if
// the patch has no inner texels or has fewer than five quads around a wrapped axis. They also must
// if two of its texels share a particle, or if one of its inner texels shares a particle with
// another patch.
std::vector<char> patches_left_alone(const Atlas& atlas);

// Returns, for every particle, the particle that replaces it on the borders of patches, or itself.
// Borders are cut into stretches at the corners of patches, at particles with more than two
// neighbours along borders, and at all particles of patches in `left_alone`. A ring without such a
// particle is cut at one. The ends of a stretch are kept. Patches that share a stretch also share
// its samples. Samples divide a stretch into one part per block along it, counted on the patch with
// the finest blocks. There are more parts if two stretches would otherwise become the same edge.
//
// `levels` is by patch. Beyond its last level a patch keeps every vertex; a patch with a wrapped
// axis has at least level 2. `left_alone` is the result of patches_left_alone(). O(n log n) for n
// particles.
std::vector<int> sampled_borders(const Pyramid& pyramid, std::span<const int> levels,
                                 std::span<const char> left_alone);

}  // namespace weft::bsi
