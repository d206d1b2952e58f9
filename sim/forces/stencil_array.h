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

// The pairs of nodes that a stencil couples.
struct EveryPair {
  static constexpr int nodes_in_a_row = 1;
  static constexpr bool has(int, int) { return true; }
};
// Of the corners of a quad, as bsi::quad_triangles has them: those of its triangles' edges.
struct QuadEdges {
  static constexpr int nodes_in_a_row = 2;  // corner 1 follows 0 in memory, and 3 follows 2
  static constexpr bool has(int a, int b) { return a + b != 3 || a * b != 0; }
};

// Stencils of `Nodes` particles each, cut into chunks of consecutive stencils; chunks of one colour
// share no particle, so they run side by side, colour after colour. Chunks and colours depend on
// the stencils alone, so a particle collects its contributions in the same order whatever the
// number of threads. Formulas take them one by one or in batches of eight (materials/lanes.h).
//
// Stencils along a row of an image have nodes that are neighbours in memory: batches of these are
// read and added to eight particles at a time.
template <int Nodes, class Pairs = EveryPair>
class StencilArray {
 public:
  using Stencil = std::array<int, Nodes>;
  using Lanes = materials::Lanes;
  using NodeValues = materials::NodesOf<Lanes, Nodes>;  // of a batch

  StencilArray() = default;
  StencilArray(const std::vector<Stencil>& stencils, int particle_count)
      : nodes_(batches_of(static_cast<int>(stencils.size()))),
        count_(static_cast<int>(stencils.size())) {
    for (int i = 0; i < lane_count * static_cast<int>(nodes_.size()); ++i) {
      for (int node = 0; node < Nodes; ++node)
        nodes_[i / lane_count][node].values[i % lane_count] =
            stencils[std::min(i, count_ - 1)][node];
    }
    find_runs();
    colour_chunks(particle_count);
  }

  int count() const { return count_; }
  Stencil operator[](int i) const {
    Stencil stencil;
    for (int node = 0; node < Nodes; ++node)
      stencil[node] = nodes_[i / lane_count][node].values[i % lane_count];
    return stencil;
  }

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
      for (int i = first; i < last; i += lane_count) body(i);
    });
  }

  // The values at the nodes of a batch; beyond the last stencil, those of the last once more.
  NodeValues gather(int first, std::span<const Vec3> values) const {
    if (is_run(first)) return gather_run(first, values);
    NodeValues result;
    gather_one_by_one(first, values, result);
    return result;
  }
  bool is_run(int first) const { return runs_[first / lane_count] != 0; }
  NodeValues gather_run(int first, std::span<const Vec3> values) const {
    NodeValues result;
#pragma GCC unroll 6
    for (int node = 0; node < Nodes; node += Pairs::nodes_in_a_row) {
      const double* start = values[nodes_[first / lane_count][node].values[0]].data();
      const auto here = materials::load_vectors(start);
      for (int axis = 0; axis < 3; ++axis) {
        result(axis, node) = here[axis];
        if constexpr (Pairs::nodes_in_a_row == 2)
          result(axis, node + 1) = materials::moved_down(here[axis], start[3 * lane_count + axis]);
      }
    }
    return result;
  }
  // Adds what a batch computed to its nodes, node after node.
  void scatter(int first, const NodeValues& values, std::span<Vec3> sums) const {
    if (is_run(first)) return scatter_run(first, values, sums);
    scatter_one_by_one(first, values, sums);
  }
  void scatter_run(int first, const NodeValues& values, std::span<Vec3> sums) const {
#pragma GCC unroll 6
    for (int node = 0; node < Nodes; node += Pairs::nodes_in_a_row) {
      double* sum = sums[nodes_[first / lane_count][node].values[0]].data();
      std::array<Lanes, 3> here{values(0, node), values(1, node), values(2, node)};
      if constexpr (Pairs::nodes_in_a_row == 2) {
        // Added to memory one after the other, the second would wait for the first.
        for (int axis = 0; axis < 3; ++axis) {
          here[axis] += materials::moved_up(values(axis, node + 1));
          sum[3 * lane_count + axis] += values(axis, node + 1).values[lane_count - 1];
        }
      }
      materials::add_vectors(here, sum);
    }
  }
  // Adds the blocks of a batch to a matrix.
  void scatter(int first, const materials::StencilMatrix<Lanes, Nodes>& values,
               BlockMatrix& matrix) const {
    const int lanes = lanes_of(first);
    const auto& nodes = nodes_[first / lane_count];
    int pair = 0;
    for (int a = 0; a < Nodes; ++a) {
      add_blocks(lanes, values(a, a), diagonal_places(nodes[a], matrix.pattern()), matrix);
      for (int b = a + 1; b < Nodes; ++b) {
        if (!Pairs::has(a, b)) continue;
        add_blocks(lanes, as_stored(values(a, b), nodes[a], nodes[b]),
                   places_[first / lane_count][pair++], matrix);
      }
    }
  }

  // Adds one block to all coupled pairs of a stencil's nodes. Precondition: it is symmetric, and no
  // two nodes of a stencil are one particle.
  void scatter_to_all(int first, const materials::Mat3Of<Lanes>& value, BlockMatrix& matrix) const {
    const int lanes = lanes_of(first);
    const auto rows = rows_of(value);
    int pair = 0;
    for (int a = 0; a < Nodes; ++a) {
      const Integers& nodes = nodes_[first / lane_count][a];
      add_blocks(lanes, value, rows, diagonal_places(nodes, matrix.pattern()), matrix);
      for (int b = a + 1; b < Nodes; ++b) {
        if (Pairs::has(a, b))
          add_blocks(lanes, value, rows, places_[first / lane_count][pair++], matrix);
      }
    }
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const {
    for (int i = 0; i < count(); ++i) {
      const Stencil stencil = (*this)[i];
      for (int a = 0; a < Nodes; ++a) {
        for (int b = 0; b < Nodes; ++b) {
          if (Pairs::has(a, b)) neighbours[stencil[a]].push_back(stencil[b]);
        }
      }
    }
  }

  // Finds where the blocks of each stencil's pairs lie in matrices of this pattern.
  void attach(const BlockPattern& pattern) {
    places_.resize(nodes_.size());
    for (int i = 0; i < count(); ++i) {
      const Stencil stencil = (*this)[i];
      int pair = 0;
      for (int a = 0; a < Nodes; ++a) {
        for (int b = a + 1; b < Nodes; ++b) {
          if (!Pairs::has(a, b)) continue;
          const int row = std::min(stencil[a], stencil[b]);
          const int column = std::max(stencil[a], stencil[b]);
          places_[i / lane_count][pair++].values[i % lane_count] =
              pattern.upper(row, pattern.slot(row, column));
        }
      }
    }
  }

  // Adds a symmetric `value` to the diagonal blocks of both nodes of stencil i and takes it from
  // the block between them.
  void add_pair(int i, const Mat3& value, BlockMatrix& matrix) const requires(Nodes == 2) {
    for (int node : (*this)[i]) matrix.upper_block(matrix.pattern().upper_diagonal(node)) += value;
    matrix.upper_block(places_[i / lane_count][0].values[i % lane_count]) -= value;
  }

 private:
  static constexpr int lane_count = materials::lane_count;
  static constexpr int stencils_a_chunk = 512;  // whole batches

  // One number of each stencil of a batch.
  struct Integers {
    typedef int Vector __attribute__((vector_size(sizeof(int) * lane_count)));
    Vector values;
  };

  static int batches_of(int count) { return (count + lane_count - 1) / lane_count; }

  // Calls body(first, last) for each chunk of stencils.
  template <class Body>
  void for_each_chunk(int threads, const Body& body) const {
    // One loop for both, as in sim/parallel.h.
    const auto passes = threads > 1 ? std::span(colours_) : std::span(&order_, 1);
    for (const std::vector<int>& chunks : passes) {
      const int chunk_count = static_cast<int>(chunks.size());
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1 && chunk_count > 1)
      for (int c = 0; c < chunk_count; ++c) {
        const int first = chunks[c] * stencils_a_chunk;
        const int last = std::min(count(), first + stencils_a_chunk);
        body(first, last);
      }
    }
  }

  // Apart from the short ways, which are better for it.
  [[gnu::noinline]] void gather_one_by_one(int first, std::span<const Vec3> values,
                                           NodeValues& result) const {
    for (int node = 0; node < Nodes; ++node) {
      const Integers& nodes = nodes_[first / lane_count][node];
      std::array<const double*, lane_count> at;
      for (int lane = 0; lane < lane_count; ++lane) at[lane] = values[nodes.values[lane]].data();
      // Numbers put into a vector one by one would wait in memory for the last of them.
      for (int axis = 0; axis < 3; ++axis) {
        result(axis, node) =
            Lanes(Lanes::Vector{at[0][axis], at[1][axis], at[2][axis], at[3][axis], at[4][axis],
                                at[5][axis], at[6][axis], at[7][axis]});
      }
    }
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

  void find_runs() {
    runs_.assign(nodes_.size(), 1);
    for (std::size_t batch = 0; batch < nodes_.size(); ++batch) {
      for (int node = 0; node < Nodes; ++node) {
        const int start = nodes_[batch][node - node % Pairs::nodes_in_a_row].values[0];
        for (int lane = 0; lane < lane_count; ++lane) {
          runs_[batch] &= static_cast<char>(nodes_[batch][node].values[lane] ==
                                            start + node % Pairs::nodes_in_a_row + lane);
        }
      }
    }
  }

  int lanes_of(int first) const { return std::min(materials::lane_count, count() - first); }

  static Integers diagonal_places(const Integers& nodes, const BlockPattern& pattern) {
    Integers places;
    for (int lane = 0; lane < lane_count; ++lane)
      places.values[lane] = pattern.upper_diagonal(nodes.values[lane]);
    return places;
  }

  // Of the blocks between nodes a and b, those above the diagonal: the transpose where a is behind
  // b, and both where they are one particle.
  static materials::Mat3Of<Lanes> as_stored(const materials::Mat3Of<Lanes>& value,
                                            const Integers& a, const Integers& b) {
    const auto as_mask = [](const auto& mask) {
      return __builtin_convertvector(mask, Lanes::Mask);
    };
    const Lanes::Mask is_transposed = as_mask(a.values > b.values);
    const Lanes::Mask is_one = as_mask(a.values == b.values);
    bool any_is_one = false;
    for (int lane = 0; lane < lane_count; ++lane) any_is_one |= a.values[lane] == b.values[lane];
    materials::Mat3Of<Lanes> result;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        result(i, j) = materials::choose(is_transposed, value(j, i), value(i, j));
    }
    if (!any_is_one) return result;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) result(i, j) += materials::choose(is_one, value(j, i), 0.0);
    }
    return result;
  }

  // The first eight numbers of the block of each stencil.
  using Rows = std::array<Lanes::Vector, lane_count>;
  static Rows rows_of(const materials::Mat3Of<Lanes>& value) {
    Rows rows;
    for (int i = 0; i < 8; ++i) rows[i] = value.data()[i].values;
    materials::transpose(rows);
    return rows;
  }

  // Adds the block of each stencil to the upper block at its place.
  static void add_blocks(int lanes, const materials::Mat3Of<Lanes>& value, const Integers& places,
                         BlockMatrix& matrix) {
    add_blocks(lanes, value, rows_of(value), places, matrix);
  }
  static void add_blocks(int lanes, const materials::Mat3Of<Lanes>& value, const Rows& rows,
                         const Integers& places, BlockMatrix& matrix) {
    typedef double UnalignedVector
        __attribute__((vector_size(sizeof(Lanes::Vector)), aligned(8), may_alias));
#pragma GCC unroll 8
    for (int lane = 0; lane < lane_count; ++lane) {
      if (lane == lanes) break;
      double* block = matrix.upper_block(places.values[lane]).data();
      *reinterpret_cast<UnalignedVector*>(block) += rows[lane];
      block[8] += value.data()[8].values[lane];
    }
  }

  void colour_chunks(int particle_count) {
    const int chunks = (count() + stencils_a_chunk - 1) / stencils_a_chunk;
    std::vector<std::vector<int>> taken(particle_count);  // taken[particle][colour]: by which chunk
    std::vector<std::size_t> colour_of;
    for (int c = 0; c < chunks; ++c) {
      std::vector<char> used(colours_.size() + 1, 0);
      for_each_particle(c, [&](int particle) {
        for (std::size_t k = 0; k < taken[particle].size(); ++k) used[k] |= taken[particle][k] >= 0;
      });
      const std::size_t colour = std::find(used.begin(), used.end(), 0) - used.begin();
      if (colour == colours_.size()) colours_.emplace_back();
      colours_[colour].push_back(c);
      colour_of.push_back(colour);
      for_each_particle(c, [&](int particle) {
        if (taken[particle].size() <= colour) taken[particle].resize(colour + 1, -1);
        taken[particle][colour] = c;
      });
    }
    // Chunk after chunk, but those of lower colours that share particles with it before each.
    std::vector<char> is_ordered(chunks, 0);
    const auto put_in_order = [&](const auto& self, int c) -> void {
      if (is_ordered[c]) return;
      is_ordered[c] = 1;
      for_each_particle(c, [&](int particle) {
        for (std::size_t k = 0; k < colour_of[c]; ++k) {
          if (taken[particle][k] >= 0) self(self, taken[particle][k]);
        }
      });
      order_.push_back(c);
    };
    for (int c = 0; c < chunks; ++c) put_in_order(put_in_order, c);
  }
  template <class Body>
  void for_each_particle(int chunk, const Body& body) const {
    const int first = chunk * stencils_a_chunk;
    const int last = std::min(count(), first + stencils_a_chunk);
    for (int i = first; i < last; ++i) {
      for (int particle : (*this)[i]) body(particle);
    }
  }

  // By batch; beyond the last stencil, the nodes of the last once more.
  std::vector<std::array<Integers, Nodes>> nodes_;
  // By batch: whether the nodes of each place are eight neighbours in memory, in order.
  std::vector<char> runs_;
  static constexpr int pair_count = [] {
    int count = 0;
    for (int a = 0; a < Nodes; ++a) {
      for (int b = a + 1; b < Nodes; ++b) count += Pairs::has(a, b) ? 1 : 0;
    }
    return count;
  }();
  std::vector<std::array<Integers, pair_count>> places_;  // of the coupled pairs (0, 1), (0, 2) ..
  std::vector<std::vector<int>> colours_;                 // chunks of each colour
  // All chunks for one thread: each particle meets them in the order of their colours, but they
  // stay near each other, where a matrix that does not fit into the cache would be read once a
  // colour.
  std::vector<int> order_;
  int count_ = 0;
};

}  // namespace weft::sim
