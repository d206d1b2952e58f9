// The borders of patches at reduced detail: selects the border vertices that remain. For
// level_of_detail.cpp.
#pragma once

#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// Returns 1 for each patch whose texels must all keep their own vertices, else 0. Such a patch has
// no inner texels, wraps too few quads or is sewn to itself.
std::vector<char> patches_left_alone(const Atlas& atlas);

// Returns, for every particle, the particle that replaces it on the borders of patches, or itself.
// Patches that share a stretch of border share its samples. A stretch has as many parts as its
// finest patch has blocks along it. `levels` is by patch; beyond its last level a patch keeps every
// vertex. Ends of stretches are kept: corners of patches, and vertices at which other patches begin
// or end. Distinct stretches never become the same edge. O(particles).
std::vector<int> sampled_borders(const Pyramid& pyramid, std::span<const int> levels,
                                 std::span<const char> left_alone);

}  // namespace weft::bsi
