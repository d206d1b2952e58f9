// The borders of patches at reduced detail: which of their vertices are kept. For
// level_of_detail.cpp.
#pragma once

#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// Returns, by patch, true where all texels must keep their own vertices: no level of the pyramid
// has a block inside, a wrapped axis has too few quads, or the patch is sewn to itself.
std::vector<char> patches_left_alone(const Atlas& atlas);

// Returns for every particle the one that stands for it on the borders of patches, or itself.
// Patches that share a stretch of border share its samples. The stretch has as many parts as the
// finest of these patches has blocks along it (`levels`, by patch; beyond the last level every
// vertex is kept). Ends of stretches are kept: corners of patches, and vertices at which other
// patches begin or end. Distinct stretches never become the same edge. O(texels of borders).
std::vector<int> sampled_borders(const Pyramid& pyramid, std::span<const int> levels,
                                 std::span<const char> left_alone);

}  // namespace weft::bsi
