// Points of a quadrature rule, sorted by the element in which they lie.
#pragma once

#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace weft::sim {

template <class Point>
class ElementPoints {
 public:
  // Adds a point. Points of one element remain in the order in which they were added.
  void add(int element, const Point& point) { unsorted_.emplace_back(element, point); }
  // Sorts the points by element. `elements` is the number of elements. Must be called once, after
  // the last add() and before of().
  void finish(int elements) {
    first_.assign(elements + 1, 0);
    for (const auto& [element, point] : unsorted_) ++first_[element + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<int> place(first_);
    points_.resize(unsorted_.size());
    for (const auto& [element, point] : unsorted_) points_[place[element]++] = point;
    unsorted_ = {};
  }

  std::span<const Point> of(int element) const {
    return std::span(points_).subspan(first_[element], first_[element + 1] - first_[element]);
  }

 private:
  std::vector<std::pair<int, Point>> unsorted_;
  std::vector<Point> points_;
  std::vector<int> first_;  // index of the first point, by element
};

}  // namespace weft::sim
