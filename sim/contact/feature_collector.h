// Conversion of pairs of quads to pairs of features.
#pragma once

#include <span>

#include "bsi/detail/neighbourhoods.h"
#include "bsi/traversal.h"
#include "sim/contact/contact_search.h"

namespace weft::sim {

// Positions of all surface points at both ends of their straight paths, m. Both are the same list
// if nothing moves.
struct PathEnds {
  std::span<const Vec3> start, end;
};

// The distances (m) up to which pairs of features are listed.
struct ListReach {
  double contact = 0;     // of pairs that can be in contact
  double neighbours = 0;  // of neighbours at rest, at most `contact`
  // Neighbourhoods at rest, for pairs of one body; null if they are rings.
  const bsi::Neighbourhoods* neighbourhoods = nullptr;
};

// Fills the lists of `list` with pairs of features of the given quad pairs. These include all
// vertex-triangle and edge-edge pairs that come within their `reach` on the paths, and a few other
// pairs near each other. Each pair occurs once, sorted by (a, b). Features that share a vertex or
// are sewn together, and pairs without a free point, are left out. FeaturePair::distance is a lower
// bound along the path.
void collect_features(const Scene& scene, const PathEnds& path,
                      std::span<const bsi::LeafPair> quad_pairs, const ListReach& reach,
                      CandidateList& list, Counters& counters);

}  // namespace weft::sim
