// The nodes of stencils in batches, with functions that read and add values at their particles.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "materials/types.h"
#include "sim/base/vectors.h"
#include "sim/forces/stencil_layout.h"

namespace weft::sim {

// Stencils of `Nodes` particles each, in batches of consecutive stencils (materials/lanes.h).
// Copies of the last stencil fill up the last batch.
//
// A batch is a run if each of its nodes stands for consecutive particles, as along a row of an
// image. If a node follows another (stencil_layout.h), its particle in each stencil of a run is the
// one after the particle of the other node. Values of a run are read and added as vectors.
template <int Nodes, class Layout>
class StencilNodes {
 public:
  using Stencil = std::array<int, Nodes>;
  using Lanes = materials::Lanes;
  // One vector per node and stencil of a batch.
  using NodeValues = materials::NodesOf<Lanes, Nodes>;

  StencilNodes() = default;
  StencilNodes(const std::vector<Stencil>& stencils, int particle_count)
      : nodes_((stencils.size() + lane_count - 1) / lane_count),
        count_(static_cast<int>(stencils.size())) {
    for (int i = 0; i < lane_count * batch_count(); ++i) {
      for (int node = 0; node < Nodes; ++node)
        nodes_[i / lane_count][node].values[i % lane_count] =
            stencils[std::min(i, count_ - 1)][node];
    }
    find_absent_nodes();
    for (int batch = 0; batch < batch_count(); ++batch) replace_absent_nodes(batch, particle_count);
    find_runs();
  }

  int count() const { return count_; }
  int batch_count() const { return static_cast<int>(nodes_.size()); }
  // Returns the number of stencils in the batch whose first stencil is `first`.
  int lanes_of(int first) const { return std::min(lane_count, count() - first); }
  // Returns the particles of a batch, with other particles in place of absent nodes.
  const std::array<LaneIntegers, Nodes>& batch(int first) const {
    return nodes_[first / lane_count];
  }
  Stencil operator[](int i) const {
    Stencil stencil;
    for (int node = 0; node < Nodes; ++node)
      stencil[node] =
          is_absent(i, node) ? no_node : nodes_[i / lane_count][node].values[i % lane_count];
    return stencil;
  }
  // Returns the particles of all stencils, stencil by stencil, with other particles in place of
  // absent nodes.
  std::vector<int> particles() const {
    std::vector<int> particles;
    particles.reserve(static_cast<std::size_t>(Nodes) * count_);
    for (int i = 0; i < count_; ++i) {
      for (const LaneIntegers& node : batch(i)) particles.push_back(node.values[i % lane_count]);
    }
    return particles;
  }

  bool is_run(int first) const { return runs_[first / lane_count] != 0; }

  NodeValues gather(int first, std::span<const Vec3> values) const {
    if (is_run(first)) return gather_run(first, values);
    NodeValues result;
    gather_one_by_one(first, values, result);
    return result;
  }
  NodeValues gather_run(int first, std::span<const Vec3> values) const {
    NodeValues result;
#pragma GCC unroll 8
    for (int node = 0; node < Nodes; ++node) {
      const int start = nodes_[first / lane_count][node].values[0];
      const auto here = materials::load_vectors(values[start].data());
      for (int axis = 0; axis < 3; ++axis) result(axis, node) = here[axis];
    }
    return result;
  }
  [[gnu::noinline]] void scatter_one_by_one(int first, const NodeValues& values,
                                            std::span<Vec3> sums) const {
    const int lanes = lanes_of(first);
    for (int lane = 0; lane < lanes; ++lane) {
      for (int node = 0; node < Nodes; ++node) {
        Vec3& sum = sums[nodes_[first / lane_count][node].values[lane]];
        for (int axis = 0; axis < 3; ++axis) sum[axis] += values(axis, node).values[lane];
      }
    }
  }

 private:
  static constexpr int lane_count = materials::lane_count;

  // Not inlined, because the compiler then produces better code for the callers.
  [[gnu::noinline]] void gather_one_by_one(int first, std::span<const Vec3> values,
                                           NodeValues& result) const {
    for (int node = 0; node < Nodes; ++node) {
      const LaneIntegers& nodes = nodes_[first / lane_count][node];
      std::array<const double*, lane_count> at;
      for (int lane = 0; lane < lane_count; ++lane) at[lane] = values[nodes.values[lane]].data();
      // Makes a vector from all its numbers at once. If the numbers were first written to memory
      // one by one, loading the vector would wait for the last of them.
      const auto together = [&]<int... lane>(int axis, std::integer_sequence<int, lane...>) {
        return Lanes(Lanes::Vector{at[lane][axis]...});
      };
      for (int axis = 0; axis < 3; ++axis)
        result(axis, node) = together(axis, std::make_integer_sequence<int, lane_count>());
    }
  }

  bool is_absent(int i, int node) const {
    return !absent_.empty() && ((absent_[i / lane_count][node] >> (i % lane_count)) & 1) != 0;
  }
  void find_absent_nodes() {
    std::vector<std::array<unsigned char, Nodes>> absent(nodes_.size());
    bool any = false;
    for (std::size_t batch = 0; batch < nodes_.size(); ++batch) {
      for (int node = 0; node < Nodes; ++node) {
        for (int lane = 0; lane < lane_count; ++lane) {
          if (nodes_[batch][node].values[lane] != no_node) continue;
          absent[batch][node] |= static_cast<unsigned char>(1 << lane);
          any = true;
        }
      }
    }
    if (any) absent_ = std::move(absent);
  }
  // Replaces each absent node by the particle that would continue the run of the batch. If no
  // particle has that index, the first node of the stencil replaces the absent node.
  void replace_absent_nodes(int batch, int particle_count) {
    for (int node = 0; node < Nodes; ++node) {
      auto& particles = nodes_[batch][node].values;
      int start = nodes_[batch][0].values[0];  // first particle of the run
      for (int lane = 0; lane < lane_count; ++lane) {
        if (particles[lane] != no_node) start = particles[lane] - lane;
      }
      if (Layout::follows(node)) start = nodes_[batch][node - 1].values[0] + 1;
      for (int lane = 0; lane < lane_count; ++lane) {
        if (particles[lane] != no_node) continue;
        const int other = start + lane;
        particles[lane] =
            other >= 0 && other < particle_count ? other : nodes_[batch][0].values[lane];
      }
    }
  }
  void find_runs() {
    runs_.assign(nodes_.size(), 1);
    for (std::size_t batch = 0; batch < nodes_.size(); ++batch) {
      for (int node = 0; node < Nodes; ++node) {
        const auto& particles = nodes_[batch][node].values;
        const int start =
            Layout::follows(node) ? nodes_[batch][node - 1].values[0] + 1 : particles[0];
        for (int lane = 0; lane < lane_count; ++lane)
          runs_[batch] &= static_cast<char>(particles[lane] == start + lane);
      }
    }
  }

  std::vector<std::array<LaneIntegers, Nodes>> nodes_;  // particles, by batch and node
  // By batch and node: bit i is set if the stencil in lane i lacks the node. Empty if no stencil
  // lacks a node.
  std::vector<std::array<unsigned char, Nodes>> absent_;
  std::vector<char> runs_;  // by batch: nonzero if the batch is a run
  int count_ = 0;
};

}  // namespace weft::sim
