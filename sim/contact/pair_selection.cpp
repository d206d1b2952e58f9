#include "sim/contact/pair_selection.h"

#include <algorithm>

namespace weft::sim {

namespace {

// Cover the rounding of sums in float32.
constexpr float above_rounding = 1 + 1e-6F, below_rounding = 1 - 1e-6F;

}  // namespace

std::vector<int> feature_starts(std::span<const FeaturePair> pairs) {
  std::vector<int> starts;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (i == 0 || pairs[i].a != pairs[i - 1].a) starts.push_back(static_cast<int>(i));
  starts.push_back(static_cast<int>(pairs.size()));
  return starts;
}

PairSelection::PairSelection(std::span<const FeaturePair> pairs, std::span<const int> starts,
                             double within, const FeatureMotion& first, const FeatureMotion& second)
    : pairs_(pairs),
      starts_(starts),
      limit_(static_cast<float>(within) * above_rounding),
      first_(first),
      second_(second) {}

// Looks at no more than the nearest of the pairs with the same first feature.
void PairSelection::take(int begin, int end, std::vector<FeaturePair>& selected) const {
  selected.clear();
  const auto by_second = [](const FeaturePair& p, const FeaturePair& q) { return p.b < q.b; };
  const float with_second = limit_ + second_.largest * above_rounding;
  for (int feature = begin; feature < end; ++feature) {
    const std::size_t last = starts_[feature + 1];
    std::size_t i = starts_[feature];
    const float moved = first_[pairs_[i].a] * above_rounding, none_beyond = with_second + moved;
    const auto from = static_cast<std::ptrdiff_t>(selected.size());
    for (; i < last && pairs_[i].distance <= none_beyond; ++i) {
      const float both = moved + second_[pairs_[i].b] * above_rounding;
      if (pairs_[i].distance > limit_ + both) continue;
      selected.push_back(
          {pairs_[i].a, pairs_[i].b, std::max(0.0F, pairs_[i].distance * below_rounding - both)});
    }
    std::sort(selected.begin() + from, selected.end(), by_second);
  }
}

}  // namespace weft::sim
