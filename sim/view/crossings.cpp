#include "sim/view/crossings.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include "bsi/triangle_intersection.h"

namespace weft::sim {

namespace {

using bsi::Point3;
using bsi::Triangle3;
using bsi::triangles_meet;
using bsi::triangles_meet_beyond_corner;

struct Box {
  Point3 low, high;

  bool overlaps(const Box& other) const {
    bool result = true;
    for (int axis = 0; axis < 3; ++axis)
      result = result && low[axis] <= other.high[axis] && other.low[axis] <= high[axis];
    return result;
  }
  void include(const Box& other) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], other.low[axis]);
      high[axis] = std::max(high[axis], other.high[axis]);
    }
  }
};

struct Item {
  Box box;
  int surface = 0, triangle = 0;
};

Point3 to_point(const bsi::Vec3& position) {
  assert(position.allFinite());
  return {position.x(), position.y(), position.z()};
}

// Returns the triangles, with boxes that are larger by `margin` (m) on every side.
std::vector<Item> all_items(std::span<const CrossingSurface> surfaces, double margin = 0) {
  std::vector<Item> items;
  for (int surface = 0; surface < static_cast<int>(surfaces.size()); ++surface) {
    const auto& [positions, triangles, check_self] = surfaces[surface];
    for (int triangle = 0; triangle < static_cast<int>(triangles.size()); ++triangle) {
      Item& item = items.emplace_back();
      item.surface = surface;
      item.triangle = triangle;
      item.box.low = item.box.high = to_point(positions[triangles[triangle][0]]);
      for (const int particle : triangles[triangle]) {
        const Point3 point = to_point(positions[particle]);
        item.box.include({point, point});
      }
      for (int axis = 0; axis < 3; ++axis) {
        item.box.low[axis] -= margin;
        item.box.high[axis] += margin;
      }
    }
  }
  return items;
}

// A hierarchy of bounding boxes. A node holds the items [first, first + count). A node of more than
// leaf_size items is split at their median along the longest axis of its box.
class BoxTree {
 public:
  struct Node {
    Box box;
    int first = 0, count = 0;
    int left = -1, right = -1;  // indices of the child nodes; -1 in a leaf
  };

  explicit BoxTree(std::vector<Item> items) : items_(std::move(items)) {
    nodes_.reserve(items_.size());
    if (!items_.empty()) build(0, static_cast<int>(items_.size()));
  }

  // Calls visit(a, b) once for each pair of items whose boxes overlap.
  template <class Visit>
  void visit_overlaps(const Visit& visit) const {
    if (!nodes_.empty()) visit_within(nodes_[0], visit);
  }

 private:
  static constexpr int leaf_size = 4;

  int build(int first, int count) {
    const int index = static_cast<int>(nodes_.size());
    nodes_.emplace_back();
    Box box = items_[first].box;
    for (int i = first + 1; i < first + count; ++i) box.include(items_[i].box);
    int left = -1, right = -1;
    if (count > leaf_size) {
      int axis = 0;
      for (int other = 1; other < 3; ++other)
        if (box.high[other] - box.low[other] > box.high[axis] - box.low[axis]) axis = other;
      const auto begin = items_.begin() + first;
      std::nth_element(
          begin, begin + count / 2, begin + count, [axis](const Item& a, const Item& b) {
            return a.box.low[axis] + a.box.high[axis] < b.box.low[axis] + b.box.high[axis];
          });
      left = build(first, count / 2);
      right = build(first + count / 2, count - count / 2);
    }
    nodes_[index] = {box, first, count, left, right};
    return index;
  }

  template <class Visit>
  void visit_within(const Node& node, const Visit& visit) const {
    if (node.left >= 0) {
      visit_within(nodes_[node.left], visit);
      visit_within(nodes_[node.right], visit);
      visit_between(nodes_[node.left], nodes_[node.right], visit);
      return;
    }
    for (int i = node.first; i < node.first + node.count; ++i)
      for (int j = i + 1; j < node.first + node.count; ++j)
        if (items_[i].box.overlaps(items_[j].box)) visit(items_[i], items_[j]);
  }

  template <class Visit>
  void visit_between(const Node& a, const Node& b, const Visit& visit) const {
    if (!a.box.overlaps(b.box)) return;
    if (a.left >= 0 && (b.left < 0 || a.count >= b.count)) {
      visit_between(nodes_[a.left], b, visit);
      visit_between(nodes_[a.right], b, visit);
    } else if (b.left >= 0) {
      visit_between(a, nodes_[b.left], visit);
      visit_between(a, nodes_[b.right], visit);
    } else {
      for (int i = a.first; i < a.first + a.count; ++i)
        for (int j = b.first; j < b.first + b.count; ++j)
          if (items_[i].box.overlaps(items_[j].box)) visit(items_[i], items_[j]);
    }
  }

  std::vector<Item> items_;
  std::vector<Node> nodes_;
};

Triangle3 points_of(const CrossingSurface& surface, const std::array<int, 3>& corners) {
  return {to_point(surface.positions[corners[0]]), to_point(surface.positions[corners[1]]),
          to_point(surface.positions[corners[2]])};
}

// True if the triangles `a` and `b` of one surface cross, by the rules of crossings.h for triangles
// that share particles.
bool cross_within(const CrossingSurface& surface, std::array<int, 3> a, std::array<int, 3> b) {
  int shared = 0, shared_in_a = 0, shared_in_b = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a[i] != b[j]) continue;
      ++shared;
      shared_in_a = i;
      shared_in_b = j;
    }
  }
  if (shared == 0) return triangles_meet(points_of(surface, a), points_of(surface, b));
  if (shared > 1) return false;
  std::rotate(a.begin(), a.begin() + shared_in_a, a.end());
  std::rotate(b.begin(), b.begin() + shared_in_b, b.end());
  return triangles_meet_beyond_corner(points_of(surface, a), points_of(surface, b));
}

bool share_a_particle(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  return std::ranges::find_first_of(a, b) != a.end();
}

// Returns the pairs that `accept(a, b)` accepts among those whose boxes overlap. Sorted.
std::vector<Crossing> pairs_of(std::span<const CrossingSurface> surfaces, double margin,
                               const auto& accept) {
  std::vector<Crossing> pairs;
  const BoxTree tree(all_items(surfaces, margin));
  tree.visit_overlaps([&](const Item& a, const Item& b) {
    if (a.surface == b.surface && !surfaces[a.surface].check_self) return;
    if (!accept(a, b)) return;
    if (std::tie(a.surface, a.triangle) < std::tie(b.surface, b.triangle))
      pairs.push_back({a.surface, a.triangle, b.surface, b.triangle});
    else
      pairs.push_back({b.surface, b.triangle, a.surface, a.triangle});
  });
  const auto key = [](const Crossing& pair) {
    return std::tie(pair.surface_a, pair.triangle_a, pair.surface_b, pair.triangle_b);
  };
  std::sort(pairs.begin(), pairs.end(),
            [&](const Crossing& a, const Crossing& b) { return key(a) < key(b); });
  return pairs;
}

}  // namespace

std::vector<Crossing> find_crossings(std::span<const CrossingSurface> surfaces) {
  return pairs_of(surfaces, 0, [&](const Item& a, const Item& b) {
    const CrossingSurface& surface_a = surfaces[a.surface];
    const CrossingSurface& surface_b = surfaces[b.surface];
    const std::array<int, 3>& corners_a = surface_a.triangles[a.triangle];
    const std::array<int, 3>& corners_b = surface_b.triangles[b.triangle];
    return a.surface == b.surface
               ? cross_within(surface_a, corners_a, corners_b)
               : triangles_meet(points_of(surface_a, corners_a), points_of(surface_b, corners_b));
  });
}

std::vector<Crossing> find_near_triangles(std::span<const CrossingSurface> surfaces,
                                          double distance) {
  return pairs_of(surfaces, 0.5 * distance, [&](const Item& a, const Item& b) {
    return a.surface != b.surface || !share_a_particle(surfaces[a.surface].triangles[a.triangle],
                                                       surfaces[b.surface].triangles[b.triangle]);
  });
}

}  // namespace weft::sim
