// Loops over stencils that share particles, in parallel and with the same bits for any number of
// threads.
#pragma once

#include <span>
#include <vector>

#include "materials/types.h"
#include "sim/forces/run_scatter.h"
#include "sim/forces/stencil_blocks.h"
#include "sim/forces/stencil_chunks.h"
#include "sim/forces/stencil_layout.h"
#include "sim/forces/stencil_nodes.h"
#include "sim/matrix/block_matrix.h"

// Marks a function that processes a batch of stencils: all calls in it are inlined, so that numbers
// stay in registers. Sanitizers check every access: the compiler would take 20 minutes with eight
// lanes. With sanitizers, the compiler therefore chooses which calls to inline.
#if defined(WEFT_SANITIZED)
#define WEFT_FLATTEN
#else
#define WEFT_FLATTEN [[gnu::flatten]]
#endif

namespace weft::sim {

// Stencils of `Nodes` particles each, as forces use them. Loops run over chunks in parallel
// (stencil_chunks.h). Values are read and added one by one or in batches (stencil_nodes.h,
// run_scatter.h, stencil_blocks.h). stencil_layout.h describes `Layout` and absent nodes. The index
// of its first stencil identifies a batch.
template <int Nodes, class Layout = AnyStencil>
class StencilArray {
 public:
  using Stencil = typename StencilNodes<Nodes, Layout>::Stencil;
  using Lanes = materials::Lanes;
  using NodeValues = typename StencilNodes<Nodes, Layout>::NodeValues;  // of a batch
  using RunScatter = sim::RunScatter<Nodes, Layout>;

  StencilArray() = default;
  StencilArray(const std::vector<Stencil>& stencils, int particle_count)
      : nodes_(stencils, particle_count), chunks_(nodes_.particles(), Nodes, particle_count) {}

  int count() const { return nodes_.count(); }
  Stencil operator[](int i) const { return nodes_[i]; }

  // Calls body(i) for each stencil i. Calls may add to the particles of their stencil without
  // locks.
  template <class Body>
  void for_each(int threads, const Body& body) const {
    for_each_chunk(threads, [&](int first, int last) {
      for (int i = first; i < last; ++i) body(i);
    });
  }
  // Calls body(first, last) for each chunk of stencils.
  template <class Body>
  void for_each_chunk(int threads, const Body& body) const {
    chunks_.for_each(threads, body);
  }
  // Calls body(first stencil index) for each batch of consecutive stencils.
  template <class Body>
  void for_each_batch(int threads, const Body& body) const {
    for_each_chunk(threads, [&](int first, int last) {
      for (int i = first; i < last; i += materials::lane_count) body(i);
    });
  }

  // Returns the values at the nodes of a batch. Lanes beyond the last stencil repeat its values.
  NodeValues gather(int first, std::span<const Vec3> values) const {
    return nodes_.gather(first, values);
  }
  // True if the nodes of a batch are neighbours in memory, as gather_run() and RunScatter require.
  // A caller that checks first keeps its numbers in registers; values read or added one by one pass
  // through memory.
  bool is_run(int first) const { return nodes_.is_run(first); }
  NodeValues gather_run(int first, std::span<const Vec3> values) const {
    return nodes_.gather_run(first, values);
  }
  // Adds the values of a batch to `sums` at the particles of its nodes.
  void scatter(int first, const NodeValues& values, std::span<Vec3> sums) const {
    if (!is_run(first)) return nodes_.scatter_one_by_one(first, values, sums);
    RunScatter run = scatter_runs(sums);
    run.add(first, values);
    run.finish();
  }
  // Returns an object that adds consecutive batches to `sums`, for batches that are runs.
  RunScatter scatter_runs(std::span<Vec3> sums) const { return RunScatter(nodes_, sums); }

  // Adds the blocks of a batch to a matrix: block_of(a, b) for each coupled pair of nodes a <= b,
  // given as integral constants. Precondition: attach().
  template <class BlockOf>
  void scatter_blocks(int first, const BlockOf& block_of, BlockMatrix& matrix) const {
    blocks_.scatter(nodes_, first, block_of, matrix);
  }
  void scatter(int first, const materials::StencilMatrix<Lanes, Nodes>& values,
               BlockMatrix& matrix) const {
    scatter_blocks(
        first, [&](auto a, auto b) -> const auto& { return values(a, b); }, matrix);
  }
  // Adds a symmetric `value` to the diagonal blocks of both nodes of stencil i and subtracts it
  // from the block between them. Precondition: attach().
  void add_pair(int i, const Mat3& value, BlockMatrix& matrix) const requires(Nodes == 2) {
    for (int node : (*this)[i]) matrix.upper_block(matrix.pattern().upper_diagonal(node)) += value;
    matrix.upper_block(blocks_.place(i, 0)) -= value;
  }

  // Adds the blocks of stencil i to a matrix. Precondition: attach(); all pairs are coupled, and no
  // node is absent.
  void add_blocks(int i, const materials::StencilMatrix<double, Nodes>& values,
                  BlockMatrix& matrix) const {
    const Stencil stencil = (*this)[i];
    for (int a = 0, pair = 0; a < Nodes; ++a) {
      matrix.upper_block(matrix.pattern().upper_diagonal(stencil[a])) += values(a, a);
      for (int b = a + 1; b < Nodes; ++b) {
        auto block = matrix.upper_block(blocks_.place(i, pair++));
        if (stencil[a] < stencil[b]) block += values(a, b);
        if (stencil[a] > stencil[b]) block += values(a, b).transpose();
      }
    }
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
  // Finds the places of the blocks of each stencil's pairs in matrices of this pattern.
  void attach(const BlockPattern& pattern) { blocks_.attach(nodes_, pattern); }

 private:
  StencilNodes<Nodes, Layout> nodes_;
  StencilChunks chunks_;
  StencilBlocks<Nodes, Layout> blocks_;
};

}  // namespace weft::sim
