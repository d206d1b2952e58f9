// Conversion of pairs of quads to pairs of features.
#pragma once

#include <span>

#include "bsi/detail/fold_watch.h"
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
  // These hold for vertices of body_a and of body_b with triangles, and for two edges.
  double first_vertices = 0, second_vertices = 0, edges = 0;
  double neighbours = 0;  // of neighbours at rest, no more than the others
  // Neighbourhoods at rest of vertices of body_a in body_b, and of those of body_b in body_a: the
  // same for pairs of one body. Null if neighbours have a common vertex or points that are sewn
  // together.
  const bsi::Neighbourhoods* first_near = nullptr;
  const bsi::Neighbourhoods* second_near = nullptr;
  // Says which quads of one body are out of reach of each other; null for two bodies.
  const bsi::FoldWatch* folds = nullptr;
};

// The pairs that are looked for, and where.
struct FeatureQuery {
  PathEnds path;
  std::span<const bsi::LeafPair> quad_pairs;
  ListReach reach;
  // One mark per surface point. Pairs that have no point with a mark are known already; all others
  // are found anew. If it is empty, all pairs are found anew.
  std::span<const char> renewed;
};

// Completes `pairs`, those of the bodies of `list`, with pairs of features of the given quad pairs.
// `pairs` then contains all vertex-triangle and edge-edge pairs that come within their reach on the
// paths, and a few other pairs near each other. Each pair occurs once. Features
// that share a vertex or are sewn together, and pairs without a free point, are left out.
// FeaturePair::distance is a lower bound along the path. Pairs are sorted by (a, b). Precondition:
// `pairs` was complete for the same reach and the same paths of points without a mark.
void collect_features(const Scene& scene, const CandidateList& list, const FeatureQuery& query,
                      FeaturePairs& pairs, Counters& counters);

}  // namespace weft::sim
