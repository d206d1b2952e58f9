// Selects the candidates among the pairs of a list.
#pragma once

#include <span>
#include <vector>

#include "sim/contact/contact_search.h"

namespace weft::sim {

// A pair is a candidate if its features, since the list was built, may have come within a distance.
class PairSelection {
 public:
  // `within` (m) is the distance, `first` and `second` are the motions of the features since the
  // list was built. All must outlive the object.
  PairSelection(std::span<const FeaturePair> pairs, double within, const FeatureMotion& first,
                const FeatureMotion& second);

  // Returns the candidates among the pairs with numbers `begin` to `end` - 1, in their order. Their
  // distances are lower bounds of the present ones. They are stored in `room`, which grows to the
  // number of the pairs. 2 ns per pair.
  std::span<const FeaturePair> take(int begin, int end, std::vector<FeaturePair>& room) const;

 private:
  std::span<const FeaturePair> pairs_;
  float limit_;  // m, distance within which a pair is a candidate if its features have not moved
  FeatureMotion first_, second_;
};

}  // namespace weft::sim
