// Running over stencils that share particles, in parallel, with the same bits for any number of
// threads.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "materials/types.h"
#include "sim/forces/block_matrix.h"
#include "sim/forces/force.h"

namespace weft::sim {

// Stencils of `Nodes` particles each, cut into chunks of consecutive stencils; chunks of one colour
// share no particle, so they run side by side, colour after colour. Chunks and colours depend on
// the stencils alone, so a particle collects its contributions in the same order whatever the
// number of threads. Formulas take them one by one or in batches of eight (materials/lanes.h).
template <int Nodes>
class StencilArray {
 public:
  using Stencil = std::array<int, Nodes>;
  using Lanes = materials::Lanes;

  StencilArray() = default;
  StencilArray(std::vector<Stencil> stencils, int particle_count) : stencils_(std::move(stencils)) {
    colour_chunks(particle_count);
  }

  int count() const { return static_cast<int>(stencils_.size()); }
  const Stencil& operator[](int i) const { return stencils_[i]; }

  // Calls body(stencil index); bodies may add to the particles of their stencil.
  template <class Body>
  void for_each(int threads, const Body& body) const {
    for_each_chunk(threads, [&](int first, int last) {
      for (int i = first; i < last; ++i) body(i);
    });
  }
  // Calls body(first stencil index) for each batch of eight consecutive stencils.
  template <class Body>
  void for_each_batch(int threads, const Body& body) const {
    for_each_chunk(threads, [&](int first, int last) {
      for (int i = first; i < last; i += materials::lane_count) body(i);
    });
  }

  // The values at the nodes of a batch; beyond the last stencil, those of the last once more.
  materials::NodesOf<Lanes, Nodes> gather(int first, std::span<const Vec3> values) const {
    materials::NodesOf<Lanes, Nodes> nodes;
    for (int lane = 0; lane < materials::lane_count; ++lane) {
      const Stencil& stencil = stencils_[std::min(first + lane, count() - 1)];
      for (int node = 0; node < Nodes; ++node) {
        for (int axis = 0; axis < 3; ++axis)
          nodes(axis, node).values[lane] = values[stencil[node]][axis];
      }
    }
    return nodes;
  }
  // Adds what a batch computed to its nodes, stencil after stencil.
  void scatter(int first, const materials::NodesOf<Lanes, Nodes>& values,
               std::span<Vec3> sums) const {
    for (int lane = 0; lane < lanes_of(first); ++lane) {
      const Stencil& stencil = stencils_[first + lane];
      for (int node = 0; node < Nodes; ++node) {
        for (int axis = 0; axis < 3; ++axis)
          sums[stencil[node]][axis] += values(axis, node).values[lane];
      }
    }
  }
  // Adds the blocks of a batch to a matrix.
  void scatter(int first, const materials::StencilMatrix<Lanes, Nodes>& values,
               BlockMatrix& matrix) const {
    int pair = 0;
    for (int a = 0; a < Nodes; ++a) {
      scatter_diagonal(first, a, values(a, a), matrix);
      for (int b = a + 1; b < Nodes; ++b) scatter_pair(first, pair++, a, b, values(a, b), matrix);
    }
  }

  // Adds the blocks of a batch of D; where it is joined to K, to those in `stiffness`, which are
  // yet to be scattered.
  void scatter_damping(int first, const materials::StencilMatrix<Lanes, Nodes>& values,
                       const Derivatives& into,
                       materials::StencilMatrix<Lanes, Nodes>& stiffness) const {
    if (!into.is_joined()) {
      scatter(first, values, *into.damping);
      return;
    }
    scatter(first, values.times(gather(first, into.along)), into.product);
    for (std::size_t k = 0; k < values.blocks.size(); ++k)
      stiffness.blocks[k] += into.inverse_gamma * values.blocks[k];
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const {
    for (const Stencil& stencil : stencils_) {
      for (int a : stencil) {
        for (int b : stencil) neighbours[a].push_back(b);
      }
    }
  }

  // Finds where the blocks of each stencil's pairs lie in matrices of this pattern.
  void attach(const BlockPattern& pattern) {
    places_.resize(stencils_.size());
    for (std::size_t i = 0; i < stencils_.size(); ++i) {
      int pair = 0;
      for (int a = 0; a < Nodes; ++a) {
        for (int b = a + 1; b < Nodes; ++b) {
          const int row = std::min(stencils_[i][a], stencils_[i][b]);
          const int column = std::max(stencils_[i][a], stencils_[i][b]);
          places_[i][pair++] = pattern.upper(row, pattern.slot(row, column));
        }
      }
    }
  }

  // Adds a symmetric `value` to the diagonal blocks of both nodes of stencil i and takes it from
  // the block between them.
  void add_pair(int i, const Mat3& value, BlockMatrix& matrix) const requires(Nodes == 2) {
    for (int node : stencils_[i])
      matrix.upper_block(matrix.pattern().upper_diagonal(node)) += value;
    matrix.upper_block(places_[i][0]) -= value;
  }

 private:
  static constexpr int stencils_a_chunk = 512;  // whole batches

  // Calls body(first, last) for each chunk of stencils.
  template <class Body>
  void for_each_chunk(int threads, const Body& body) const {
    for (const std::vector<int>& chunks : colours_) {
      const int chunk_count = static_cast<int>(chunks.size());
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1 && chunk_count > 1)
      for (int c = 0; c < chunk_count; ++c) {
        const int first = chunks[c] * stencils_a_chunk;
        const int last = std::min(count(), first + stencils_a_chunk);
        body(first, last);
      }
    }
  }

  int lanes_of(int first) const { return std::min(materials::lane_count, count() - first); }

  // Adds the nine numbers of each stencil's block, the last of which stays in its place, to the
  // upper blocks that `place(lane)` gives; those of -1 are left out.
  template <class Place>
  static void scatter_block(int lanes, const Lanes* value, const std::array<int, 8>& order,
                            const Place& place, BlockMatrix& matrix) {
    using Vector = Lanes::Vector;
    typedef double UnalignedVector
        __attribute__((vector_size(sizeof(Vector)), aligned(8), may_alias));
    std::array<Vector, materials::lane_count> rows;
    for (int i = 0; i < 8; ++i) rows[i] = value[order[i]].values;
    materials::transpose(rows);
    for (int lane = 0; lane < lanes; ++lane) {
      const int upper = place(lane);
      if (upper < 0) continue;
      double* block = matrix.upper_block(upper).data();
      *reinterpret_cast<UnalignedVector*>(block) += rows[lane];
      block[8] += value[8].values[lane];
    }
  }
  void scatter_diagonal(int first, int node, const materials::Mat3Of<Lanes>& value,
                        BlockMatrix& matrix) const {
    const BlockPattern& pattern = matrix.pattern();
    scatter_block(
        lanes_of(first), value.data(), {0, 1, 2, 3, 4, 5, 6, 7},
        [&](int lane) { return pattern.upper_diagonal(stencils_[first + lane][node]); }, matrix);
  }
  // The block of nodes a and b, or its transpose where that is the one above the diagonal: in most
  // batches the same for all stencils. Both, where the nodes are one particle.
  void scatter_pair(int first, int pair, int a, int b, const materials::Mat3Of<Lanes>& value,
                    BlockMatrix& matrix) const {
    const int lanes = lanes_of(first);
    const auto place = [&](int lane, int from, int to) {
      const Stencil& stencil = stencils_[first + lane];
      return stencil[from] <= stencil[to] ? places_[first + lane][pair] : -1;
    };
    const auto scatter_side = [&](int from, int to, const std::array<int, 8>& order) {
      bool is_stored = false;
      for (int lane = 0; lane < lanes; ++lane) is_stored |= place(lane, from, to) >= 0;
      if (!is_stored) return;
      scatter_block(
          lanes, value.data(), order, [&](int lane) { return place(lane, from, to); }, matrix);
    };
    scatter_side(a, b, {0, 1, 2, 3, 4, 5, 6, 7});
    scatter_side(b, a, {0, 3, 6, 1, 4, 7, 2, 5});
  }

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
  std::vector<std::array<int, Nodes*(Nodes - 1) / 2>> places_;  // of the pairs (0, 1), (0, 2) ..
  std::vector<std::vector<int>> colours_;                       // chunks of each colour
};

}  // namespace weft::sim
