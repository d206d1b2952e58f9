// Running over stencils that share particles, in parallel, with the same bits for any number of
// threads.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "sim/forces/block_matrix.h"
#include "sim/forces/force.h"

namespace weft::sim {

// Stencils of `Nodes` particles each, cut into chunks of consecutive stencils; chunks of one colour
// share no particle, so they run side by side, colour after colour. Chunks and colours depend on
// the stencils alone, so a particle collects its contributions in the same order whatever the
// number of threads.
template <int Nodes>
class StencilArray {
 public:
  using Stencil = std::array<int, Nodes>;

  StencilArray() = default;
  StencilArray(std::vector<Stencil> stencils, int particle_count) : stencils_(std::move(stencils)) {
    colour_chunks(particle_count);
  }

  int count() const { return static_cast<int>(stencils_.size()); }
  const Stencil& operator[](int i) const { return stencils_[i]; }

  // Calls body(stencil index); bodies may add to the particles of their stencil.
  template <class Body>
  void for_each(int threads, const Body& body) const {
    for (const std::vector<int>& chunks : colours_) {
      const int chunk_count = static_cast<int>(chunks.size());
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1 && chunk_count > 1)
      for (int c = 0; c < chunk_count; ++c) {
        const int first = chunks[c] * stencils_a_chunk;
        const int last = std::min(count(), first + stencils_a_chunk);
        for (int i = first; i < last; ++i) body(i);
      }
    }
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const {
    for (const Stencil& stencil : stencils_) {
      for (int a : stencil) {
        for (int b : stencil) neighbours[a].push_back(b);
      }
    }
  }

  // Finds where the blocks of each stencil lie in matrices of this pattern: those above the
  // diagonal or on it; -1 for their mirror images.
  void attach(const BlockPattern& pattern) {
    slots_.resize(stencils_.size());
    for (std::size_t i = 0; i < stencils_.size(); ++i) {
      for (int a = 0; a < Nodes; ++a) {
        for (int b = 0; b < Nodes; ++b) {
          const int row = stencils_[i][a], column = stencils_[i][b];
          slots_[i][a * Nodes + b] =
              row <= column ? pattern.upper(row, pattern.slot(row, column)) : -1;
        }
      }
    }
  }

  // Adds a symmetric (3 Nodes) x (3 Nodes) matrix of stencil i.
  template <class Matrix>
  void add_block_matrix(int i, const Matrix& value, BlockMatrix& matrix) const {
    for (int a = 0; a < Nodes; ++a) {
      for (int b = 0; b < Nodes; ++b)
        add_block(i, a, b, value.template block<3, 3>(3 * a, 3 * b), matrix);
    }
  }
  // Adds block (a, b) of such a matrix; whoever adds one adds its mirror image, too.
  template <class Block>
  void add_block(int i, int a, int b, const Block& value, BlockMatrix& matrix) const {
    const int slot = slots_[i][a * Nodes + b];
    if (slot >= 0) matrix.upper_block(slot) += value;
  }

 private:
  static constexpr int stencils_a_chunk = 512;

  void colour_chunks(int particle_count) {
    const int chunks = (count() + stencils_a_chunk - 1) / stencils_a_chunk;
    std::vector<std::vector<char>> taken(particle_count);  // taken[particle][colour]
    for (int c = 0; c < chunks; ++c) {
      const int first = c * stencils_a_chunk;
      const int last = std::min(count(), first + stencils_a_chunk);
      std::vector<char> used(colours_.size() + 1, 0);
      for (int i = first; i < last; ++i) {
        for (int particle : stencils_[i]) {
          for (std::size_t k = 0; k < taken[particle].size(); ++k) used[k] |= taken[particle][k];
        }
      }
      const std::size_t colour = std::find(used.begin(), used.end(), 0) - used.begin();
      if (colour == colours_.size()) colours_.emplace_back();
      colours_[colour].push_back(c);
      for (int i = first; i < last; ++i) {
        for (int particle : stencils_[i]) {
          if (taken[particle].size() <= colour) taken[particle].resize(colour + 1, 0);
          taken[particle][colour] = 1;
        }
      }
    }
  }

  std::vector<Stencil> stencils_;
  std::vector<std::array<int, Nodes * Nodes>> slots_;
  std::vector<std::vector<int>> colours_;  // chunks of each colour
};

}  // namespace weft::sim
