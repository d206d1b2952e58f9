// The places of the blocks of stencils in matrices with a given block pattern.
#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <vector>

#include "sim/base/prefetch.h"
#include "sim/forces/block_batch.h"
#include "sim/forces/stencil_nodes.h"
#include "sim/matrix/tiled_matrix.h"

namespace weft::sim {

template <int Nodes, class Layout>
class StencilBlocks {
 public:
  using Stencils = StencilNodes<Nodes, Layout>;

  // Stores the place of the block of each coupled pair of nodes.
  void attach(const Stencils& stencils, const BlockPattern& pattern) {
    places_.resize(stencils.batch_count());
    for (int batch = 0; batch < stencils.batch_count(); ++batch) {
      const int first = batch * lane_count;
      int pair = 0;
      for_each_coupled_pair<Nodes, Layout>([&](int a, int b) {
        for (int lane = 0; lane < lane_count; ++lane) {
          const typename Stencils::Stencil stencil =
              stencils[std::min(first + lane, stencils.count() - 1)];
          places_[batch].first[pair].values[lane] =
              place_of(stencil, stencil[a], stencil[b], pattern);
        }
        places_[batch].runs[pair] = are_run(places_[batch].first[pair]);
        ++pair;
      });
    }
  }

  // Returns the place of the first entry of the block of a coupled pair of nodes a <= b of stencil
  // i. Coupled pairs are numbered by a, then by b.
  int place(int i, int pair) const {
    return places_[i / lane_count].first[pair].values[i % lane_count];
  }

  // Adds the blocks of a batch to a matrix. block_of(a, b) returns the blocks of nodes a and b; a
  // and b are integral constants. It is called for each coupled pair with a <= b.
  template <class BlockOf>
  void scatter(const Stencils& stencils, int first, const BlockOf& block_of,
               const BlockTarget& into) const {
    prefetch(places_, first / lane_count + 1);
    const int lanes = stencils.lanes_of(first);
    const auto& nodes = stencils.batch(first);
    const BatchPlaces& all = places_[first / lane_count];
    int pair = 0;
    for_each_coupled_pair<Nodes, Layout>([&](auto a, auto b) {
      const BlockPlaces places{all.first[pair], all.runs[pair]};
      ++pair;
      if constexpr (a == b) {
        add_block(lanes, block_of(a, b), places, into);
      } else {
        add_pair_block(lanes, block_of(a, b), nodes[a], nodes[b], places, into);
      }
    });
  }

 private:
  static constexpr int lane_count = materials::lane_count;
  static constexpr int pair_count = Nodes + coupled_pair_count<Nodes, Layout>();

  // Places by coupled pair. Bit i of `runs` is set if the blocks of pair i are a run.
  struct BatchPlaces {
    std::array<LaneIntegers, pair_count> first;
    std::bitset<pair_count> runs;
  };

  // Returns the place of the block of particles a and b. If a or b is absent, returns the place of
  // the diagonal block of the stencil's first node. The block of an absent node must be zero.
  static int place_of(const typename Stencils::Stencil& stencil, int a, int b,
                      const BlockPattern& pattern) {
    if (a == no_node || b == no_node) a = b = stencil[0];
    const int row = std::min(a, b);
    return pattern.layout().first(pattern.upper(row, pattern.slot(row, std::max(a, b))));
  }
  static bool are_run(const LaneIntegers& first) {
    for (int lane = 1; lane < lane_count; ++lane) {
      if (first.values[lane] != first.values[0] + lane) return false;
    }
    return true;
  }

  std::vector<BatchPlaces> places_;
};

}  // namespace weft::sim
