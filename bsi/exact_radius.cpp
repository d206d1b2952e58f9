#include "bsi/exact_radius.h"

#include <array>
#include <cmath>

#include "bsi/sphere_bounds.h"

namespace weft::bsi {

namespace {

struct Node {
  int level, u, v;
};

class FarthestVertex {
 public:
  FarthestVertex(const SphereTree& tree, const SphereVertices& vertices, int patch,
                 const float* centre, float squared)
      : tree_(tree),
        vertices_(vertices),
        patch_(patch),
        depth_(tree.numbers->at(patch, tree.numbers->levels(patch) - 1)),
        quad_rows_(tree.atlas->patches()[patch].quad_rows()),
        centre_(centre),
        squared_(squared) {}

  float search(const Node& block) {
    visit_corners(block);
    // A descent leaves at most three siblings behind on each of 31 levels.
    std::array<Node, 96> pending;
    int count = 0;
    pending[count++] = block;
    while (count > 0) {
      const Node node = pending[--count];
      const BlockLevel& here = tree_.numbers->at(patch_, node.level);
      const int log_u = depth_.log_u - here.log_u, log_v = depth_.log_v - here.log_v;
      if (log_u <= visited_log && log_v <= visited_log) {
        visit(node, log_u, log_v);
        continue;
      }
      const BlockLevel& below = tree_.numbers->at(patch_, node.level + 1);
      const int split_u = below.log_u - here.log_u, split_v = below.log_v - here.log_v;
      const float found = std::sqrt(squared_);
      for (int v = node.v << split_v; v < (node.v + 1) << split_v; ++v) {
        for (int u = node.u << split_u; u < (node.u + 1) << split_u; ++u) {
          if (may_reach_beyond(tree_.spheres[below.block(u, v)], found)) {
            pending[count++] = {node.level + 1, u, v};
          }
        }
      }
    }
    return squared_;
  }

 private:
  int vertex_row(int v, int log) const { return block_boundary(v, quad_rows_, log); }

  void visit_corners(const Node& block) {
    const BlockLevel& here = tree_.numbers->at(patch_, block.level);
    const int log_u = depth_.log_u - here.log_u;
    for (int end = 0; end < vertices_.ends; ++end) {
      const std::array rows{vertices_.row(end, vertex_row(block.v, here.log_v)),
                            vertices_.row(end, vertex_row(block.v + 1, here.log_v))};
      for (int u = block.u; u <= block.u + 1; ++u) {
        squared_ = kernels_.reach_of_block(rows.data(), 2, u << log_u, 0, centre_, squared_);
      }
    }
  }

  void visit(const Node& block, int log_u, int log_v) {
    const int log = depth_.log_v - log_v;
    const int first = vertex_row(block.v, log), last = vertex_row(block.v + 1, log);
    std::array<SphereVertexRow, (1 << visited_log) + 1> rows;
    for (int end = 0; end < vertices_.ends; ++end) {
      for (int row = first; row <= last; ++row) rows[row - first] = vertices_.row(end, row);
      squared_ = kernels_.reach_of_block(rows.data(), last - first + 1, block.u << log_u,
                                         1 << log_u, centre_, squared_);
    }
  }

  bool may_reach_beyond(const Sphere& sphere, float found) const {
    const float x = sphere.x - centre_[0], y = sphere.y - centre_[1], z = sphere.z - centre_[2];
    return (std::sqrt(x * x + y * y + z * z) + sphere.radius) * prune_factor > found;
  }

  const SphereTree& tree_;
  const SphereVertices& vertices_;
  int patch_;
  BlockLevel depth_;
  int quad_rows_;
  const float* centre_;
  float squared_;
  const SphereKernels& kernels_ = sphere_kernels();
};

}  // namespace

float squared_reach(const SphereTree& tree, const SphereVertices& vertices, int patch, int level,
                    int u, int v, const float* centre, float squared) {
  return FarthestVertex(tree, vertices, patch, centre, squared).search({level, u, v});
}

}  // namespace weft::bsi
