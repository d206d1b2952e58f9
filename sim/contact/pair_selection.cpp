#include "sim/contact/pair_selection.h"

#include <algorithm>

namespace weft::sim {

namespace {

// Cover the rounding of sums in float32.
constexpr float above_rounding = 1 + 1e-6F, below_rounding = 1 - 1e-6F;

// Reads the motions of features without a branch.
class Motions {
 public:
  explicit Motions(const FeatureMotion& motion)
      : each_(motion.each.empty() ? &motion.largest : motion.each.data()),
        stride_(motion.each.empty() ? 0 : 1) {}
  float operator[](int feature) const {
    return each_[static_cast<std::ptrdiff_t>(feature) * stride_] * above_rounding;
  }

 private:
  const float* each_;
  std::ptrdiff_t stride_;
};

}  // namespace

PairSelection::PairSelection(std::span<const FeaturePair> pairs, double within,
                             const FeatureMotion& first, const FeatureMotion& second)
    : pairs_(pairs),
      limit_(static_cast<float>(within) * above_rounding),
      first_(first),
      second_(second) {}

// Writes each pair, and keeps it if it is a candidate. Which pairs are candidates is hard to
// predict, so that branches would take longer.
std::span<const FeaturePair> PairSelection::take(int begin, int end,
                                                 std::vector<FeaturePair>& room) const {
  const Motions first(first_), second(second_);
  if (std::ssize(room) < end - begin) room.resize(end - begin);
  int count = 0;
  for (const auto& [a, b, distance] : pairs_.subspan(begin, end - begin)) {
    const float both = first[a] + second[b];
    room[count] = {a, b, std::max(0.0F, distance * below_rounding - both)};
    count += static_cast<int>(distance <= limit_ + both);
  }
  return std::span(room).first(count);
}

}  // namespace weft::sim
