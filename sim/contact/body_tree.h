// A tree of the boxes of bodies. It finds the pairs of bodies whose boxes meet.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

namespace weft::sim {

// A binary tree of axis-aligned boxes. The bodies of a node are halved at the median of their
// boxes' middles along the longest axis. When a body moves, its box is replaced, and the boxes
// above it grow to contain the new one. The tree is rebuilt once as many boxes were replaced as
// there are bodies. Finding the neighbours of all of n bodies costs O(n log n) if few boxes meet.
class BodyTree {
 public:
  using Box = Eigen::AlignedBox3d;

  // Builds the tree. boxes[i] is the box of body i, m. A body with an empty box has no neighbours.
  void build(std::vector<Box> boxes);
  bool is_built() const { return !boxes_.empty(); }
  const Box& box(int body) const { return boxes_[body]; }
  // Replaces the boxes of some bodies: boxes[i] is the new box of bodies[i], m.
  void move(std::span<const int> bodies, std::span<const Box> boxes);
  // Calls visit(other) for every other body whose box meets that of `body`. Returns the number of
  // boxes compared.
  template <class Visit>
  int visit_neighbours(int body, const Visit& visit) const;
  // Calls visit(body) for every body whose box meets `box` (m). Returns the number of boxes
  // compared.
  template <class Visit>
  int visit_meeting(const Box& box, const Visit& visit) const;

 private:
  struct Node {
    Box box;
    int parent = -1;
    int left = -1, right = -1;  // indices of nodes; -1 in a leaf
    int body = -1;              // body of a leaf; -1 in other nodes
  };
  int add_node(std::span<int> bodies, int parent);

  std::vector<Box> boxes_;  // by body
  std::vector<Node> nodes_;
  std::vector<int> leaf_of_;  // by body: index of its leaf in nodes_
  std::size_t moved_ = 0;     // number of boxes replaced since the tree was built
};

template <class Visit>
int BodyTree::visit_neighbours(int body, const Visit& visit) const {
  return visit_meeting(boxes_[body], [&](int other) {
    if (other != body) visit(other);
  });
}

template <class Visit>
int BodyTree::visit_meeting(const Box& box, const Visit& visit) const {
  if (nodes_.empty()) return 0;
  int compared = 0;
  std::vector<int> open{0};
  while (!open.empty()) {
    const Node& node = nodes_[open.back()];
    open.pop_back();
    ++compared;
    if (!node.box.intersects(box)) continue;
    if (node.left >= 0) {
      open.push_back(node.right);
      open.push_back(node.left);
    } else {
      visit(node.body);
    }
  }
  return compared;
}

}  // namespace weft::sim
