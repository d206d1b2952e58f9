// Running over stencils that share particles, in parallel, with the same bits for any number of
// threads.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "materials/types.h"
#include "sim/forces/force.h"
#include "sim/matrix/block_matrix.h"

// Marks a function that takes a batch of stencils: all that it calls becomes part of it, so that
// numbers stay in registers. Sanitizers check every access in it, which keeps the compiler busy for
// 20 minutes with eight lanes: with them, the compiler chooses what to put in.
#if defined(WEFT_SANITIZED)
#define WEFT_FLATTEN
#else
#define WEFT_FLATTEN [[gnu::flatten]]
#endif

namespace weft::sim {

// How a stencil lies in an image: which pairs of nodes it couples, and which nodes follow the one
// before them in memory, in the rows of an image.
struct AnyStencil {
  static constexpr bool follows(int) { return false; }
  static constexpr bool couples(int, int) { return true; }
};
// The corners of a quad, as bsi::quad_triangles has them: its triangles' edges.
struct QuadCorners {
  static constexpr bool follows(int node) { return node == 1 || node == 3; }
  static constexpr bool couples(int a, int b) { return a + b != 3 || a * b != 0; }
};

// Stencils of `Nodes` particles each, cut into chunks of consecutive stencils; chunks of one colour
// share no particle, so they run side by side, colour after colour. Chunks and colours depend on
// the stencils alone, so a particle collects its contributions in the same order whatever the
// number of threads. Formulas take them one by one or in batches (materials/lanes.h).
//
// Stencils along a row of an image have nodes that are neighbours in memory: batches of these are
// read and added to a batch of particles at a time.
//
// Any node but the first may be absent, no_node. The value read there is that of some particle; the
// value added there must be zero.
inline constexpr int no_node = -1;

template <int Nodes, class Layout = AnyStencil>
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
    note_absent();
    for (int batch = 0; batch < static_cast<int>(nodes_.size()); ++batch)
      stand_in(batch, particle_count);
    find_runs();
    colour_chunks(particle_count);
  }

  int count() const { return count_; }
  Stencil operator[](int i) const {
    Stencil stencil;
    for (int node = 0; node < Nodes; ++node)
      stencil[node] =
          is_absent(i, node) ? no_node : nodes_[i / lane_count][node].values[i % lane_count];
    return stencil;
  }

  // Calls body(stencil index); bodies may add to the particles of their stencil.
  template <class Body>
  void for_each(int threads, const Body& body) const {
    for_each_chunk(threads, [&](int first, int last) {
      for (int i = first; i < last; ++i) body(i);
    });
  }
  // Calls body(first, last) for each chunk of stencils.
  template <class Body>
  void for_each_chunk(int threads, const Body& body) const {
    // One loop serves any number of threads, as in sim/base/parallel.h.
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
  // Calls body(first stencil index) for each batch of consecutive stencils.
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
  // True if the nodes of a batch are neighbours in memory, as gather_run() and RunScatter require.
  // A caller that asks first keeps its numbers in registers; values read or added one by one pass
  // through memory.
  bool is_run(int first) const { return runs_[first / lane_count] != 0; }
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
  // Adds what a batch computed to its nodes, node after node.
  void scatter(int first, const NodeValues& values, std::span<Vec3> sums) const {
    if (!is_run(first)) return scatter_one_by_one(first, values, sums);
    RunScatter run(*this, sums);
    run.add(first, values);
    run.finish();
  }
  // Adds the results of batches whose nodes are neighbours in memory. Of nodes that follow each
  // other only the first is added to memory, as vectors: added one after the other, each would wait
  // for the one before. The last stencil's value for a node that follows belongs to a particle of
  // the next batch. It is added with that batch if that comes next, else by finish().
  class RunScatter {
   public:
    RunScatter(const StencilArray& stencils, std::span<Vec3> sums)
        : stencils_(stencils), sums_(sums) {
      forget();
    }

    void add(int first, const NodeValues& values) {
      const auto& nodes = stencils_.nodes_[first / lane_count];
      bool is_next = true;
      for (int node = 0; node < Nodes; ++node)
        is_next &= !Layout::follows(node) || nodes[node - 1].values[0] == next_[node];
      if (!is_next) finish();
      std::array<Lanes, 3> later{};  // what the nodes behind this one add to its particles
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
        next_[node] = nodes[node].values[lane_count - 1];
      }
    }
    // Adds what waits for a batch that does not come.
    void finish() {
      for (int node = 0; node < Nodes; ++node) {
        if (!Layout::follows(node) || next_[node] == no_node) continue;
        for (int axis = 0; axis < 3; ++axis)
          sums_[next_[node]][axis] += last_[node][axis].values[lane_count - 1];
      }
      forget();
    }

   private:
    void forget() {
      last_.fill({Lanes(0), Lanes(0), Lanes(0)});
      next_.fill(no_node);
    }

    const StencilArray& stencils_;
    std::span<Vec3> sums_;
    std::array<std::array<Lanes, 3>, Nodes> last_;  // of the last batch, for nodes that follow
    std::array<int, Nodes> next_;                   // the particles of its last stencil
  };
  // Adds the blocks of a batch to a matrix: block_of(a, b) for each coupled pair of nodes a <= b,
  // given as integral constants.
  template <class BlockOf>
  void scatter_blocks(int first, const BlockOf& block_of, BlockMatrix& matrix) const {
    const int lanes = lanes_of(first);
    const auto& nodes = nodes_[first / lane_count];
    int pair = 0;
    for_each_pair([&](auto a, auto b) {
      if constexpr (a == b) {
        add_block(lanes, block_of(a, b), diagonal_places(nodes[a], matrix.pattern()), matrix);
      } else {
        add_pair_block(lanes, block_of(a, b), nodes[a], nodes[b],
                       places_[first / lane_count][pair++], matrix);
      }
    });
  }
  void scatter(int first, const materials::StencilMatrix<Lanes, Nodes>& values,
               BlockMatrix& matrix) const {
    scatter_blocks(
        first, [&](auto a, auto b) -> const auto& { return values(a, b); }, matrix);
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const {
    for (int i = 0; i < count(); ++i) {
      const Stencil stencil = (*this)[i];
      for (int a = 0; a < Nodes; ++a) {
        for (int b = 0; b < Nodes; ++b) {
          if (Layout::couples(a, b) && stencil[a] != no_node && stencil[b] != no_node)
            neighbours[stencil[a]].push_back(stencil[b]);
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
          if (!Layout::couples(a, b)) continue;
          places_[i / lane_count][pair++].values[i % lane_count] =
              place_of(stencil[a], stencil[b], i, pattern);
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

  // Calls body(a, b), integral constants, for all coupled pairs of nodes a <= b.
  template <class Body>
  static void for_each_pair(const Body& body) {
    const auto with = [&]<int a, int... b>(std::integral_constant<int, a> row,
                                           std::integer_sequence<int, b...>) {
      const auto one = [&]<int column>(std::integral_constant<int, column> other) {
        if constexpr (a <= column && Layout::couples(a, column)) body(row, other);
      };
      (one(std::integral_constant<int, b>()), ...);
    };
    [&]<int... a>(std::integer_sequence<int, a...> all) {
      (with(std::integral_constant<int, a>(), all), ...);
    }
    (std::make_integer_sequence<int, Nodes>());
  }

  bool is_absent(int i, int node) const {
    return !absent_.empty() && ((absent_[i / lane_count][node] >> (i % lane_count)) & 1) != 0;
  }
  void note_absent() {
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
  // Replaces absent nodes by particles: those that make a run with the others of the batch, or else
  // another node of the stencil.
  void stand_in(int batch, int particle_count) {
    for (int node = 0; node < Nodes; ++node) {
      auto& particles = nodes_[batch][node].values;
      int start = nodes_[batch][0].values[0];  // of the run
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

  // Absent nodes are in no pair: nothing is added to a block that is there.
  int place_of(int a, int b, int i, const BlockPattern& pattern) const {
    if (a == no_node || b == no_node) return pattern.upper_diagonal((*this)[i][0]);
    const int row = std::min(a, b);
    return pattern.upper(row, pattern.slot(row, std::max(a, b)));
  }

  // Not inlined: the short paths compile better without it.
  [[gnu::noinline]] void gather_one_by_one(int first, std::span<const Vec3> values,
                                           NodeValues& result) const {
    for (int node = 0; node < Nodes; ++node) {
      const Integers& nodes = nodes_[first / lane_count][node];
      std::array<const double*, lane_count> at;
      for (int lane = 0; lane < lane_count; ++lane) at[lane] = values[nodes.values[lane]].data();
      // Numbers put into a vector one by one would wait in memory for the last of them.
      const auto together = [&]<int... lane>(int axis, std::integer_sequence<int, lane...>) {
        return Lanes(Lanes::Vector{at[lane][axis]...});
      };
      for (int axis = 0; axis < 3; ++axis)
        result(axis, node) = together(axis, std::make_integer_sequence<int, lane_count>());
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
        const auto& particles = nodes_[batch][node].values;
        const int start =
            Layout::follows(node) ? nodes_[batch][node - 1].values[0] + 1 : particles[0];
        for (int lane = 0; lane < lane_count; ++lane)
          runs_[batch] &= static_cast<char>(particles[lane] == start + lane);
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

  // Adds the blocks between nodes a and b, to those above the diagonal: the transpose where a is
  // behind b, and both where they are one particle.
  static void add_pair_block(int lanes, const materials::Mat3Of<Lanes>& value, const Integers& a,
                             const Integers& b, const Integers& places, BlockMatrix& matrix) {
    unsigned behind = 0, one = 0;
    for (int lane = 0; lane < lane_count; ++lane) {
      behind |= static_cast<unsigned>(a.values[lane] > b.values[lane]) << lane;
      one |= static_cast<unsigned>(a.values[lane] == b.values[lane]) << lane;
    }
    constexpr unsigned all = (1U << lane_count) - 1;
    if (one == 0 && behind == 0) return add_block(lanes, value, places, matrix);
    materials::Mat3Of<Lanes> transposed;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) transposed(i, j) = value(j, i);
    }
    if (behind == all) return add_block(lanes, transposed, places, matrix);
    add_block(lanes, mixed(value, transposed, a, b), places, matrix);
  }
  static materials::Mat3Of<Lanes> mixed(const materials::Mat3Of<Lanes>& value,
                                        const materials::Mat3Of<Lanes>& transposed,
                                        const Integers& a, const Integers& b) {
    const auto as_mask = [](const auto& mask) {
      return Lanes::Mask{__builtin_convertvector(mask, Lanes::Mask::Bits)};
    };
    const Lanes::Mask is_behind = as_mask(a.values > b.values);
    const Lanes::Mask is_one = as_mask(a.values == b.values);
    materials::Mat3Of<Lanes> result;
    for (int i = 0; i < 9; ++i) {
      const Lanes here = value.data()[i], there = transposed.data()[i];
      result.data()[i] =
          materials::choose(is_behind, there, here) + materials::choose(is_one, there, 0.0);
    }
    return result;
  }

  // Returns `lane_count` numbers of the block of each stencil, from `start` on.
  using Rows = std::array<Lanes::Vector, lane_count>;
  static Rows rows_of(const materials::Mat3Of<Lanes>& value, int start) {
    Rows rows;
    for (int i = 0; i < lane_count; ++i) rows[i] = value.data()[start + i].values;
    materials::transpose(rows);
    return rows;
  }

  // Adds the block of each stencil to the upper block at its place. One piece of code for all
  // pairs: it is long.
  [[gnu::noinline]] static void add_block(int lanes, const materials::Mat3Of<Lanes>& value,
                                          const Integers& places, BlockMatrix& matrix) {
    std::array<Rows, 8 / lane_count> rows;
    for (int part = 0; part < 8 / lane_count; ++part)
      rows[part] = rows_of(value, part * lane_count);
#pragma GCC unroll 8
    for (int lane = 0; lane < lane_count; ++lane) {
      if (lane == lanes) break;
      double* block = matrix.upper_block(places.values[lane]).data();
      for (int part = 0; part < 8 / lane_count; ++part)
        reinterpret_cast<materials::UnalignedLanes*>(block)[part] += rows[part][lane];
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
      for (const Integers& nodes : nodes_[i / lane_count]) body(nodes.values[i % lane_count]);
    }
  }

  // Nodes by batch; beyond the last stencil, those of the last once more.
  std::vector<std::array<Integers, Nodes>> nodes_;
  // Bits by batch and node: the lanes whose stencil lacks the node. Empty if no node is absent.
  std::vector<std::array<unsigned char, Nodes>> absent_;
  // Nonzero, by batch, if the nodes of each place are neighbours in memory, in order.
  std::vector<char> runs_;
  static constexpr int pair_count = [] {
    int count = 0;
    for (int a = 0; a < Nodes; ++a) {
      for (int b = a + 1; b < Nodes; ++b) count += Layout::couples(a, b) ? 1 : 0;
    }
    return count;
  }();
  std::vector<std::array<Integers, pair_count>> places_;  // of the coupled pairs (0, 1), (0, 2) ..
  std::vector<std::vector<int>> colours_;                 // chunks of each colour
  // The order of all chunks for one thread. Each particle meets its chunks in the order of their
  // colours, but chunks stay near each other. Colour after colour, a matrix that does not fit into
  // the cache would be read once per colour.
  std::vector<int> order_;
  int count_ = 0;
};

}  // namespace weft::sim
