// Chunks of stencils that run in parallel, with the same bits for any number of threads.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "bsi/detail/team.h"

namespace weft::sim {

// Divides stencils into chunks of consecutive stencils. Each chunk has a colour, and chunks of one
// colour share no particle. Several threads process one colour after the other. Chunks and colours
// depend on the stencils alone, so every particle receives its contributions in the same order on
// any number of threads.
class StencilChunks {
 public:
  StencilChunks() = default;
  // `particles` lists the particles stencil by stencil, `nodes` of them per stencil.
  StencilChunks(std::span<const int> particles, int nodes, int particle_count);

  // Calls body(first, last) for each chunk of stencils.
  template <class Body>
  void for_each(int threads, const Body& body) const {
    // One thread processes all chunks in a single pass, several threads process one colour per
    // pass.
    const auto passes = threads > 1 ? std::span(colours_) : std::span(&order_, 1);
    for (const std::vector<int>& chunks : passes) {
      bsi::parallel_for(static_cast<int>(chunks.size()), threads, [&](int c) {
        const int first = chunks[c] * stencils_per_chunk_;
        body(first, std::min(stencil_count_, first + stencils_per_chunk_));
      });
    }
  }

 private:
  int stencil_count_ = 0, stencils_per_chunk_ = 0;
  std::vector<std::vector<int>> colours_;  // chunks by colour
  // The order in which one thread processes all chunks. Chunks that share a particle are in the
  // order of their colours, and neighbouring chunks stay close to each other. If the order were
  // colour by colour, a matrix larger than the cache would be read once per colour.
  std::vector<int> order_;
};

}  // namespace weft::sim
