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
#include "sim/matrix/tiled_matrix.h"

// Marks a function that processes batches of stencils. Calls in it are inlined, except those of
// functions marked noinline, so that numbers stay in registers. With sanitizers, the compiler
// chooses which calls to inline, because inlining all of them would take it many minutes.
#if defined(WEFT_SANITIZED)
#define WEFT_FLATTEN
#else
#define WEFT_FLATTEN [[gnu::flatten]]
#endif

namespace weft::sim {

// Stencils of `Nodes` particles each, as forces use them. Loops run over chunks of stencils in
// parallel (stencil_chunks.h). Values are read and added for one stencil or for a batch
// (stencil_nodes.h, run_scatter.h, stencil_blocks.h). A batch is identified by the index of its
// first stencil. stencil_layout.h explains `Layout` and absent nodes.
template <int Nodes, class Layout = AnyStencil>
class StencilArray {
 public:
  using Stencil = typename StencilNodes<Nodes, Layout>::Stencil;
  using Lanes = materials::Lanes;
  // One vector per node and stencil of a batch.
  using NodeValues = typename StencilNodes<Nodes, Layout>::NodeValues;
  using RunScatter = sim::RunScatter<Nodes, Layout>;

  StencilArray() = default;
  StencilArray(const std::vector<Stencil>& stencils, int particle_count)
      : nodes_(stencils, particle_count), chunks_(nodes_.particles(), Nodes, particle_count) {}

  int count() const { return nodes_.count(); }
  Stencil operator[](int i) const { return nodes_[i]; }

  // Calls body(i) for each stencil i. body(i) may add to values of its stencil's particles without
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
  // Returns true if the batch is a run, which gather_run() and RunScatter require. They keep values
  // in registers. In other batches, values are read or added one by one and pass through memory.
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
  // Returns an object that adds the values of consecutive batches to `sums`. Precondition of each
  // batch: is_run().
  RunScatter scatter_runs(std::span<Vec3> sums) const { return RunScatter(nodes_, sums); }

  // Adds the blocks of a batch to a matrix. block_of(a, b) returns the blocks of nodes a and b; a
  // and b are integral constants. It is called for each coupled pair with a <= b. Precondition:
  // attach().
  template <class BlockOf>
  void scatter_blocks(int first, const BlockOf& block_of, const BlockTarget& into) const {
    blocks_.scatter(nodes_, first, block_of, into);
  }
  void scatter(int first, const materials::StencilMatrix<Lanes, Nodes>& values,
               BlockMatrix& matrix) const {
    scatter_blocks(first, [&](auto a, auto b) -> const auto& { return values(a, b); }, {matrix});
  }
  // Adds a symmetric `value` to the diagonal blocks of both nodes of stencil i and subtracts it
  // from the block between them. Precondition: attach().
  void add_pair(int i, const Mat3& value, BlockMatrix& matrix) const requires(Nodes == 2) {
    matrix.block_at(blocks_.place(i, 0)) += value;
    matrix.block_at(blocks_.place(i, 1)) -= value;
    matrix.block_at(blocks_.place(i, 2)) += value;
  }

  // Adds the blocks of stencil i to a matrix. Preconditions: attach() was called, all pairs of
  // nodes are coupled, and the nodes are different particles, none of them absent.
  void add_blocks(int i, const materials::StencilMatrix<double, Nodes>& values,
                  BlockMatrix& matrix) const {
    const Stencil stencil = (*this)[i];
    for (int a = 0, pair = 0; a < Nodes; ++a) {
      matrix.block_at(blocks_.place(i, pair++)) += values(a, a);
      for (int b = a + 1; b < Nodes; ++b) {
        auto block = matrix.block_at(blocks_.place(i, pair++));
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
  // Stores the index of the block of each coupled pair of different nodes in matrices with this
  // pattern.
  void attach(const BlockPattern& pattern) { blocks_.attach(nodes_, pattern); }

 private:
  StencilNodes<Nodes, Layout> nodes_;
  StencilChunks chunks_;
  StencilBlocks<Nodes, Layout> blocks_;
};

}  // namespace weft::sim
