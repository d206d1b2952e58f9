// Selects the candidates among the pairs of a list.
#pragma once

#include <span>
#include <vector>

#include "sim/contact/contact_search.h"

namespace weft::sim {

// A pair is a candidate if its features, since the list was built, may have come within a distance.
class PairSelection {
 public:
  // `pairs` is sorted by the first feature, and pairs with the same one by their distances in the
  // list. `within` (m) is the distance, `first` and `second` are the motions of the features since
  // the list was built. All must outlive the object.
  PairSelection(std::span<const FeaturePair> pairs, double within, const FeatureMotion& first,
                const FeatureMotion& second);

  // Sets `selected` to the candidates whose first feature is that of one of the pairs `begin` to
  // `end` - 1, but not of the pair before them, sorted by both features. Their distances become
  // lower bounds of the present ones. Calls for all parts of the list take each candidate once.
  // O(pairs within the distance and the motion of their first feature).
  void take(int begin, int end, std::vector<FeaturePair>& selected) const;

 private:
  std::size_t next_feature(std::size_t i) const;

  std::span<const FeaturePair> pairs_;
  float limit_;  // m, distance within which a pair is a candidate if its features have not moved
  FeatureMotion first_, second_;
};

}  // namespace weft::sim
