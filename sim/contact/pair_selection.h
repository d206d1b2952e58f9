// Selects the candidates among the pairs of a list.
#pragma once

#include <span>
#include <vector>

#include "sim/contact/contact_search.h"

namespace weft::sim {

// Returns the indices at which the pairs of another first feature begin, followed by the number of
// pairs. `pairs` is sorted by the first feature. O(pairs).
std::vector<int> feature_starts(std::span<const FeaturePair> pairs);

// A pair is a candidate if its features, since the list was built, may have come within a distance.
class PairSelection {
 public:
  // `pairs` is sorted by the first feature, and pairs with the same one by their distances in the
  // list. `starts` is feature_starts(pairs). `within` (m) is the distance, `first` and `second` are
  // the motions of the features since the list was built. All must outlive the object.
  PairSelection(std::span<const FeaturePair> pairs, std::span<const int> starts, double within,
                const FeatureMotion& first, const FeatureMotion& second);

  // Returns the number of first features that have pairs.
  int features() const { return static_cast<int>(starts_.size()) - 1; }
  // Sets `selected` to the candidates of the first features with numbers `begin` to `end` - 1,
  // sorted by both features. Their distances become lower bounds of the present ones. O(features,
  // and pairs within the distance and the motion of their first feature).
  void take(int begin, int end, std::vector<FeaturePair>& selected) const;

 private:
  std::span<const FeaturePair> pairs_;
  std::span<const int> starts_;
  float limit_;  // m, distance within which a pair is a candidate if its features have not moved
  FeatureMotion first_, second_;
};

}  // namespace weft::sim
