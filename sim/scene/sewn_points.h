// Surface points that seams hold together, which contact must not push apart.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace weft::sim {

struct Scene;

// Features of which one has a point that is sewn to a point of the other touch, as features that
// share a vertex do. They are no candidates of contact.
class SewnPoints {
 public:
  SewnPoints() = default;  // of a scene without seams
  // Finds the points that the seams of a scene hold together, directly or through others. The
  // surface points of the scene must have their numbers. O(points + stitches).
  explicit SewnPoints(const Scene& scene);

  bool is_empty() const { return others_.empty(); }
  bool are_joined(int point, int other) const {
    const auto first = others_.begin() + first_[point], last = others_.begin() + first_[point + 1];
    return std::binary_search(first, last, other);
  }
  // True if one of the first `split` points is sewn to one of the others.
  bool are_joined(const std::array<int, 4>& points, int split) const {
    for (int i = 0; i < split; ++i) {
      for (int j = split; j < 4; ++j) {
        if (are_joined(points[i], points[j])) return true;
      }
    }
    return false;
  }
  // Calls visit(point, other) for all pairs with point < other, in order.
  template <class Visit>
  void visit_pairs(const Visit& visit) const {
    for (int point = 0; point + 1 < static_cast<int>(first_.size()); ++point) {
      for (int i = first_[point]; i < first_[point + 1]; ++i) {
        if (point < others_[i]) visit(point, others_[i]);
      }
    }
  }

 private:
  std::vector<int> first_;   // by point, one more at the end; empty without seams
  std::vector<int> others_;  // sorted for each point
};

}  // namespace weft::sim
