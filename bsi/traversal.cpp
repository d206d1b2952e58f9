#include "bsi/traversal.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace weft::bsi {

namespace {

// A node of the tree with its sphere, fetched once.
struct Node {
  Block block;
  Sphere sphere;
};

struct NodePair {
  Node a;
  Node b;
};

Node node_of(const Pyramid& pyramid, const Block& block) { return {block, pyramid.sphere(block)}; }

int children_of(const Pyramid& pyramid, const Block& block, std::array<Node, 4>& child) {
  std::array<Block, 4> blocks;
  const int count = pyramid.children(block, blocks);
  for (int i = 0; i < count; ++i) child[i] = node_of(pyramid, blocks[i]);
  return count;
}

// The smallest float32 number that is certain not to be less.
float rounded_up(double value) {
  const auto rounded = static_cast<float>(value);
  if (static_cast<double>(rounded) >= value) return rounded;
  return std::nextafter(rounded, std::numeric_limits<float>::infinity());
}

float float_margin(double margin) {
  assert(margin >= 0);
  return rounded_up(margin);
}

// A float32 sphere around a float64 ball.
Sphere sphere_around(const Vec3& centre, double radius) {
  assert(centre.cwiseAbs().maxCoeff() < static_cast<double>(Pyramid::coordinate_limit));
  const Eigen::Vector3f rounded = centre.cast<float>();
  const double moved = (rounded.cast<double>() - centre).norm();
  // The factor covers what the float64 operations round. The floor keeps squares off underflow.
  const double reach = std::max((radius + moved) * (1 + 0x1p-49), 1e-18);
  return {rounded.x(), rounded.y(), rounded.z(), rounded_up(reach)};
}

// The body of the dual traversal, on two pyramids or on two blocks of one. Starts with the pairs on
// the stack, which are within the margin, and calls found(leaf of a, leaf of b).
class DualDescent {
 public:
  DualDescent(const Pyramid& first, const Pyramid& second, double margin,
              TraversalCounters& counters)
      : first_(first), second_(second), margin_(float_margin(margin)), counters_(counters) {}

  // Follows the pair later, if it is within the margin.
  void push(const Node& a, const Node& b) {
    ++counters_.sphere_tests;
    if (spheres_within(a.sphere, b.sphere, margin_)) stack_.push_back({a, b});
  }

  template <typename Found>
  void run(Found found) {
    while (!stack_.empty()) {
      const NodePair pair = stack_.back();
      stack_.pop_back();
      const bool leaf_a = first_.is_leaf(pair.a.block);
      const bool leaf_b = second_.is_leaf(pair.b.block);
      if (leaf_a && leaf_b) {
        found(first_.quad_of_leaf(pair.a.block), second_.quad_of_leaf(pair.b.block));
        continue;
      }
      std::array<Node, 4> child;
      if (leaf_b || (!leaf_a && pair.a.sphere.radius >= pair.b.sphere.radius)) {
        const int count = children_of(first_, pair.a.block, child);
        for (int i = 0; i < count; ++i) push(child[i], pair.b);
      } else {
        const int count = children_of(second_, pair.b.block, child);
        for (int i = 0; i < count; ++i) push(pair.a, child[i]);
      }
    }
  }

 private:
  const Pyramid& first_;
  const Pyramid& second_;
  float margin_;
  TraversalCounters& counters_;
  std::vector<NodePair> stack_;
};

}  // namespace

void single_traversal(const Pyramid& pyramid, const Vec3& centre, double radius, double margin,
                      std::vector<int>& quads, TraversalCounters& counters) {
  assert(pyramid.is_built());
  const Sphere ball = sphere_around(centre, radius);
  const float reach = float_margin(margin);
  std::vector<Node> stack;
  const auto push = [&](const Node& node) {
    ++counters.sphere_tests;
    if (spheres_within(node.sphere, ball, reach)) stack.push_back(node);
  };
  push(node_of(pyramid, pyramid.root()));
  while (!stack.empty()) {
    const Node node = stack.back();
    stack.pop_back();
    if (pyramid.is_leaf(node.block)) {
      quads.push_back(pyramid.quad_of_leaf(node.block));
      continue;
    }
    std::array<Node, 4> child;
    const int count = children_of(pyramid, node.block, child);
    for (int i = 0; i < count; ++i) push(child[i]);
  }
}

void dual_traversal(const Pyramid& first, const Pyramid& second, double margin,
                    std::vector<QuadPair>& pairs, TraversalCounters& counters) {
  assert(first.is_built() && second.is_built());
  DualDescent descent(first, second, margin, counters);
  descent.push(node_of(first, first.root()), node_of(second, second.root()));
  descent.run([&](int a, int b) { pairs.push_back({a, b}); });
}

void self_traversal(const Pyramid& pyramid, double margin, std::vector<QuadPair>& pairs,
                    TraversalCounters& counters) {
  assert(pyramid.is_built());
  DualDescent descent(pyramid, pyramid, margin, counters);
  std::vector<Block> stack{pyramid.root()};  // blocks paired with themselves
  while (!stack.empty()) {
    const Block block = stack.back();
    stack.pop_back();
    if (pyramid.is_leaf(block)) {
      const int quad = pyramid.quad_of_leaf(block);
      pairs.push_back({quad, quad});
      continue;
    }
    std::array<Node, 4> child;
    const int count = children_of(pyramid, block, child);
    for (int i = 0; i < count; ++i) {
      stack.push_back(child[i].block);
      for (int j = i + 1; j < count; ++j) descent.push(child[i], child[j]);
    }
    descent.run([&](int a, int b) { pairs.push_back({std::min(a, b), std::max(a, b)}); });
  }
}

}  // namespace weft::bsi
