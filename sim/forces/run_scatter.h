// Adds values of stencils along a row of an image to the particles of their nodes.
#pragma once

#include <array>
#include <span>

#include "sim/forces/stencil_nodes.h"

namespace weft::sim {

// Adds the values of batches that are runs (stencil_nodes.h). A node that follows another stands
// for the particles after those of the other node. Values of both nodes for the same particle are
// summed in registers and added to memory together, because separate additions would wait for each
// other. The value of a following node in the last stencil waits for the next batch. If the next
// batch continues the run, the value is added with that batch, otherwise by finish().
template <int Nodes, class Layout>
class RunScatter {
 public:
  using Lanes = materials::Lanes;
  // One vector per node and stencil of a batch.
  using NodeValues = materials::NodesOf<Lanes, Nodes>;

  RunScatter(const StencilNodes<Nodes, Layout>& stencils, std::span<Vec3> sums)
      : stencils_(stencils), sums_(sums) {
    forget();
  }

  void add(int first, const NodeValues& values) {
    const auto& nodes = stencils_.batch(first);
    bool is_next = true;
    for (int node = 0; node < Nodes; ++node)
      is_next &= !Layout::follows(node) || nodes[node - 1].values[0] == next_[node];
    if (!is_next) finish();
    std::array<Lanes, 3> later{};  // values of node + 1 at the particles of this node
#pragma GCC unroll 8
    for (int node = Nodes - 1; node >= 0; --node) {
      std::array<Lanes, 3> here;
      for (int axis = 0; axis < 3; ++axis) here[axis] = values(axis, node);
      if (node + 1 < Nodes && Layout::follows(node + 1)) {
        for (int axis = 0; axis < 3; ++axis) here[axis] += later[axis];
      }
      if (!Layout::follows(node)) {
        materials::add_vectors(here, sums_[nodes[node].values[0]].data());
        continue;
      }
      for (int axis = 0; axis < 3; ++axis)
        later[axis] = materials::moved_up(last_[node][axis], here[axis]);
      last_[node] = here;
      next_[node] = nodes[node].values[materials::lane_count - 1];
    }
  }
  // Adds the values that wait for the next batch. Must be called after the last add().
  void finish() {
    for (int node = 0; node < Nodes; ++node) {
      if (!Layout::follows(node) || next_[node] == no_node) continue;
      for (int axis = 0; axis < 3; ++axis)
        sums_[next_[node]][axis] += last_[node][axis].values[materials::lane_count - 1];
    }
    forget();
  }

 private:
  void forget() {
    last_.fill({Lanes(0), Lanes(0), Lanes(0)});
    next_.fill(no_node);
  }

  const StencilNodes<Nodes, Layout>& stencils_;
  std::span<Vec3> sums_;
  // Values of the last batch, by node. Used for nodes that follow others.
  std::array<std::array<Lanes, 3>, Nodes> last_;
  // By node: the particle to which its value in the last stencil of the last batch belongs. no_node
  // if no value waits.
  std::array<int, Nodes> next_;
};

}  // namespace weft::sim
