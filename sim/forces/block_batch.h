// Adds batches of 3 x 3 blocks, one block per stencil, to a block matrix.
#pragma once

#include <array>

#include "materials/types.h"
#include "sim/forces/stencil_layout.h"
#include "sim/matrix/tiled_matrix.h"

namespace weft::sim {

using BlockBatch = materials::Mat3Of<materials::Lanes>;

// The places of a batch's blocks, by stencil, in matrices with a given block pattern (BlockLayout).
// In a run, each stencil's block is the one of the row after that of the stencil before.
struct BlockPlaces {
  LaneIntegers first;
  bool are_run = false;
};

// A matrix that blocks are added to. If `scaled` is given, a matrix with the same pattern, the
// blocks times `factor`, by stencil, are added to it, too.
struct BlockTarget {
  BlockMatrix& matrix;
  BlockMatrix* scaled = nullptr;
  materials::Lanes factor = 0;
};

// Adds the blocks of the first `lanes` stencils to the blocks at `places`. Not inlined, because its
// code is long and each batch calls it for many pairs of nodes.
[[gnu::noinline]] inline void add_block(int lanes, const BlockBatch& value,
                                        const BlockPlaces& places, const BlockTarget& into) {
  // The lines of the next run are prefetched: the processor does not predict accesses to so many
  // diagonals.
  const auto add_run_to = [&](BlockMatrix& matrix, const auto& factor) {
    double* const at = matrix.values() + places.first.values[0];
#pragma GCC unroll 9
    for (int i = 0; i < 9; ++i) {
      __builtin_prefetch(at + i * BlockLayout::stride + 16, 1);
      *reinterpret_cast<materials::UnalignedLanes*>(at + i * BlockLayout::stride) +=
          (factor * value.data()[i]).values;
    }
  };
  const auto add_each_to = [&](BlockMatrix& matrix, const auto& factor) {
    std::array<materials::Lanes, 9> entries;
    for (int i = 0; i < 9; ++i) entries[i] = factor * value.data()[i];
    for (int lane = 0; lane < lanes; ++lane) {
      const int first = places.first.values[lane];
      const int stride = matrix.pattern().layout().stride_at(first);
      double* const at = matrix.values() + first;
      for (int i = 0; i < 9; ++i) at[i * stride] += entries[i].values[lane];
    }
  };
  const auto add_to = [&](BlockMatrix& matrix, const auto& factor) {
    if (places.are_run && lanes == materials::lane_count) {
      add_run_to(matrix, factor);
    } else {
      add_each_to(matrix, factor);
    }
  };
  add_to(into.matrix, 1.0);
  if (into.scaled != nullptr) add_to(*into.scaled, into.factor);
}

// Returns one block per lane for the particles a and b of a pair of nodes: `value` if a < b,
// `transposed` if a > b, and their sum if a == b.
inline BlockBatch mixed(const BlockBatch& value, const BlockBatch& transposed,
                        const LaneIntegers& a, const LaneIntegers& b) {
  using materials::Lanes;
  const auto as_mask = [](const auto& mask) {
    return Lanes::Mask{__builtin_convertvector(mask, Lanes::Mask::Bits)};
  };
  const Lanes::Mask is_behind = as_mask(a.values > b.values);
  const Lanes::Mask is_one = as_mask(a.values == b.values);
  BlockBatch result;
  for (int i = 0; i < 9; ++i) {
    const Lanes here = value.data()[i], there = transposed.data()[i];
    result.data()[i] =
        materials::choose(is_behind, there, here) + materials::choose(is_one, there, 0.0);
  }
  return result;
}

// Adds the blocks of particles a and b to the blocks at `places`. If a > b, adds the transpose. If
// a == b, adds the sum of the block and its transpose.
inline void add_pair_block(int lanes, const BlockBatch& value, const LaneIntegers& a,
                           const LaneIntegers& b, const BlockPlaces& places,
                           const BlockTarget& into) {
  unsigned behind = 0, one = 0;
  for (int lane = 0; lane < materials::lane_count; ++lane) {
    behind |= static_cast<unsigned>(a.values[lane] > b.values[lane]) << lane;
    one |= static_cast<unsigned>(a.values[lane] == b.values[lane]) << lane;
  }
  constexpr unsigned all = (1U << materials::lane_count) - 1;
  if (one == 0 && behind == 0) return add_block(lanes, value, places, into);
  BlockBatch transposed;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) transposed(i, j) = value(j, i);
  }
  if (behind == all) return add_block(lanes, transposed, places, into);
  add_block(lanes, mixed(value, transposed, a, b), places, into);
}

}  // namespace weft::sim
