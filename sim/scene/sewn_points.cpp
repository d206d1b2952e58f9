#include "sim/scene/sewn_points.h"

#include <numeric>

#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

// Points that coincide form sets, named by their lowest point (union-find).
class CoincidentPoints {
 public:
  explicit CoincidentPoints(int count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int set_of(int point) {
    while (parent_[point] != point) point = parent_[point] = parent_[parent_[point]];
    return point;
  }
  void join(int a, int b) {
    const int one = set_of(a), other = set_of(b);
    parent_[std::max(one, other)] = std::min(one, other);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace

// A vertex that is sewn to an edge between two vertices hangs on both. The neighbours of a point
// are the points of its set, of the sets on which these hang or that hang on them, and of the sets
// that hang on the same ones.
SewnPoints::SewnPoints(const Scene& scene) {
  CoincidentPoints coincident(scene.point_count);
  std::vector<std::array<int, 2>> links;
  for (const Seam& seam : scene.seams) {
    const int first = scene.bodies[scene.case_order[seam.body]].first_point;
    const int other = scene.bodies[scene.case_order[seam.to]].first_point;
    for (const Stitch& stitch : seam.stitches) {
      const int point = first + stitch.vertex;
      if (stitch.nodes[0] == stitch.nodes[1]) {
        coincident.join(point, other + stitch.nodes[0]);
      } else {
        for (const int node : stitch.nodes) links.push_back({point, other + node});
      }
    }
  }
  std::vector<std::vector<int>> members(scene.point_count), linked(scene.point_count);
  for (int point = 0; point < scene.point_count; ++point)
    members[coincident.set_of(point)].push_back(point);
  for (const auto& [a, b] : links) {
    linked[coincident.set_of(a)].push_back(coincident.set_of(b));
    linked[coincident.set_of(b)].push_back(coincident.set_of(a));
  }
  first_.push_back(0);
  for (int point = 0; point < scene.point_count; ++point) {
    const int own = coincident.set_of(point);
    std::vector<int> sets{own};
    for (const int near : linked[own]) {
      sets.push_back(near);
      sets.insert(sets.end(), linked[near].begin(), linked[near].end());
    }
    std::vector<int> others;
    for (const int set : sets)
      others.insert(others.end(), members[set].begin(), members[set].end());
    std::ranges::sort(others);
    others.erase(std::unique(others.begin(), others.end()), others.end());
    std::erase(others, point);
    others_.insert(others_.end(), others.begin(), others.end());
    first_.push_back(static_cast<int>(others_.size()));
  }
}

}  // namespace weft::sim
