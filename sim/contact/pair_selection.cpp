#include "sim/contact/pair_selection.h"

#include <algorithm>

namespace weft::sim {

namespace {

// Covers the rounding of sums in float32.
constexpr float above_rounding = 1 + 1e-6F;

}  // namespace

PairSelection::PairSelection(std::span<const FeaturePair> pairs, double within,
                             const FeatureMotion& first, const FeatureMotion& second)
    : pairs_(pairs),
      limit_(static_cast<float>(within) * above_rounding),
      first_(first),
      second_(second) {}

// Returns the first index from `i` on at which the pairs of another first feature begin.
std::size_t PairSelection::next_feature(std::size_t i) const {
  while (i > 0 && i < pairs_.size() && pairs_[i].a == pairs_[i - 1].a) ++i;
  return i;
}

// Looks at no more than the nearest of the pairs with the same first feature.
void PairSelection::take(int begin, int end, std::vector<FeaturePair>& selected) const {
  selected.clear();
  const auto by_second = [](const FeaturePair& p, const FeaturePair& q) { return p.b < q.b; };
  const std::size_t last = next_feature(end);
  for (std::size_t i = next_feature(begin); i < last;) {
    const int a = pairs_[i].a;
    const float moved = first_[a] * above_rounding;
    const float none_beyond = limit_ + moved + second_.largest * above_rounding;
    const auto from = static_cast<std::ptrdiff_t>(selected.size());
    for (; i < last && pairs_[i].a == a && pairs_[i].distance <= none_beyond; ++i) {
      const float both = moved + second_[pairs_[i].b] * above_rounding;
      if (pairs_[i].distance > limit_ + both) continue;
      selected.push_back(
          {a, pairs_[i].b, std::max(0.0F, pairs_[i].distance / above_rounding - both)});
    }
    while (i < last && pairs_[i].a == a) ++i;
    std::sort(selected.begin() + from, selected.end(), by_second);
  }
}

}  // namespace weft::sim
