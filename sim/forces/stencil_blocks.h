// The indices of the blocks of stencils in matrices with a given block pattern.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "sim/forces/block_batch.h"
#include "sim/forces/stencil_nodes.h"
#include "sim/matrix/block_matrix.h"

namespace weft::sim {

template <int Nodes, class Layout>
class StencilBlocks {
 public:
  using Stencils = StencilNodes<Nodes, Layout>;

  // Stores the index of the upper block of each coupled pair of different nodes.
  void attach(const Stencils& stencils, const BlockPattern& pattern) {
    places_.resize(stencils.batch_count());
    for (int i = 0; i < stencils.count(); ++i) {
      const typename Stencils::Stencil stencil = stencils[i];
      int pair = 0;
      for (int a = 0; a < Nodes; ++a) {
        for (int b = a + 1; b < Nodes; ++b) {
          if (!Layout::couples(a, b)) continue;
          places_[i / lane_count][pair++].values[i % lane_count] =
              place_of(stencil, stencil[a], stencil[b], pattern);
        }
      }
    }
  }

  // Returns the index of the upper block of a coupled pair of nodes a < b of stencil i. Coupled
  // pairs are numbered by a, then by b.
  int place(int i, int pair) const { return places_[i / lane_count][pair].values[i % lane_count]; }

  // Adds the blocks of a batch to a matrix. block_of(a, b) returns the blocks of nodes a and b; a
  // and b are integral constants. It is called for each coupled pair with a <= b.
  template <class BlockOf>
  void scatter(const Stencils& stencils, int first, const BlockOf& block_of,
               const BlockTarget& into) const {
    const int lanes = stencils.lanes_of(first);
    const auto& nodes = stencils.batch(first);
    int pair = 0;
    for_each_coupled_pair<Nodes, Layout>([&](auto a, auto b) {
      if constexpr (a == b) {
        add_block(lanes, block_of(a, b), diagonal_places(nodes[a], into.matrix.pattern()), into);
      } else {
        add_pair_block(lanes, block_of(a, b), nodes[a], nodes[b],
                       places_[first / lane_count][pair++], into);
      }
    });
  }

 private:
  static constexpr int lane_count = materials::lane_count;

  // Returns the index of the upper block of particles a and b. If a or b is absent, returns the
  // index of the diagonal block of the stencil's first node. The block of an absent node must be
  // zero.
  static int place_of(const typename Stencils::Stencil& stencil, int a, int b,
                      const BlockPattern& pattern) {
    if (a == no_node || b == no_node) return pattern.upper_diagonal(stencil[0]);
    const int row = std::min(a, b);
    return pattern.upper(row, pattern.slot(row, std::max(a, b)));
  }
  static LaneIntegers diagonal_places(const LaneIntegers& nodes, const BlockPattern& pattern) {
    LaneIntegers places;
    for (int lane = 0; lane < lane_count; ++lane)
      places.values[lane] = pattern.upper_diagonal(nodes.values[lane]);
    return places;
  }

  // Indices of upper blocks, by batch and coupled pair.
  std::vector<std::array<LaneIntegers, coupled_pair_count<Nodes, Layout>()>> places_;
};

}  // namespace weft::sim
