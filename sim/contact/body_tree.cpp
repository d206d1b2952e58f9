#include "sim/contact/body_tree.h"

#include <algorithm>
#include <numeric>

namespace weft::sim {

void BodyTree::build(std::vector<Box> boxes) {
  boxes_ = std::move(boxes);
  nodes_.clear();
  nodes_.reserve(2 * boxes_.size());
  leaf_of_.assign(boxes_.size(), -1);
  moved_ = 0;
  std::vector<int> bodies(boxes_.size());
  std::iota(bodies.begin(), bodies.end(), 0);
  if (!bodies.empty()) add_node(bodies, -1);
}

int BodyTree::add_node(std::span<int> bodies, int parent) {
  const int index = static_cast<int>(nodes_.size());
  Node& node = nodes_.emplace_back();
  node.parent = parent;
  for (const int body : bodies) node.box.extend(boxes_[body]);
  if (bodies.size() == 1) {
    node.body = bodies[0];
    leaf_of_[bodies[0]] = index;
    return index;
  }
  Eigen::Index axis = 0;
  node.box.sizes().maxCoeff(&axis);
  const std::size_t half = bodies.size() / 2;
  std::nth_element(bodies.begin(), bodies.begin() + static_cast<std::ptrdiff_t>(half), bodies.end(),
                   [&](int a, int b) {
                     return boxes_[a].min()[axis] + boxes_[a].max()[axis] <
                            boxes_[b].min()[axis] + boxes_[b].max()[axis];
                   });
  const int left = add_node(bodies.first(half), index);
  const int right = add_node(bodies.subspan(half), index);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return index;
}

void BodyTree::move(std::span<const int> bodies, std::span<const Box> boxes) {
  for (std::size_t i = 0; i < bodies.size(); ++i) boxes_[bodies[i]] = boxes[i];
  moved_ += bodies.size();
  if (moved_ >= boxes_.size()) return build(std::move(boxes_));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const int leaf = leaf_of_[bodies[i]];
    nodes_[leaf].box = boxes[i];
    for (int n = nodes_[leaf].parent; n >= 0 && !nodes_[n].box.contains(boxes[i]);
         n = nodes_[n].parent)
      nodes_[n].box.extend(boxes[i]);
  }
}

}  // namespace weft::sim
