// Conversion of pairs of quads to pairs of features.
#pragma once

#include <span>

#include "bsi/traversal.h"
#include "sim/contact/contact_search.h"

namespace weft::sim {

// Fills the three lists of `list` with pairs of features of the given quad pairs. These include all
// vertex-triangle and edge-edge pairs that come within `reach` (m) on the straight paths start ->
// end of all surface points, and a few other pairs near each other. Each pair occurs once, sorted
// by (a, b). Features that share a vertex or are sewn together, and pairs without a free point, are
// left out. FeaturePair::distance is a lower bound along the path.
void collect_features(const Scene& scene, std::span<const Vec3> start, std::span<const Vec3> end,
                      std::span<const bsi::LeafPair> quad_pairs, double reach, CandidateList& list,
                      Counters& counters);

}  // namespace weft::sim
