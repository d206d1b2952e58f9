// Adds batches of 3 x 3 blocks, one block per stencil, to a block matrix.
#pragma once

#include <array>

#include "materials/types.h"
#include "sim/forces/stencil_layout.h"
#include "sim/matrix/block_matrix.h"

namespace weft::sim {

using BlockBatch = materials::Mat3Of<materials::Lanes>;
using LaneRows = std::array<materials::Lanes::Vector, materials::lane_count>;

// Returns the entries start .. start + lane_count - 1 of each stencil's block. Row i has those of
// stencil i.
inline LaneRows rows_of(const BlockBatch& value, int start) {
  LaneRows rows;
  for (int i = 0; i < materials::lane_count; ++i) rows[i] = value.data()[start + i].values;
  materials::transpose(rows);
  return rows;
}

// A matrix that blocks are added to. If `scaled` is given, a matrix with the same pattern, the
// blocks times `factor`, by stencil, are added to it, too.
struct BlockTarget {
  BlockMatrix& matrix;
  BlockMatrix* scaled = nullptr;
  materials::Lanes factor = 0;
};

// Adds the blocks of the first `lanes` stencils to the upper blocks with the indices `places`. Not
// inlined, because its code is long and each batch calls it for many pairs of nodes.
[[gnu::noinline]] inline void add_block(int lanes, const BlockBatch& value,
                                        const LaneIntegers& places, const BlockTarget& into) {
  using materials::lane_count;
  std::array<LaneRows, 8 / lane_count> rows;
  for (int part = 0; part < 8 / lane_count; ++part) rows[part] = rows_of(value, part * lane_count);
#pragma GCC unroll 8
  for (int lane = 0; lane < lane_count; ++lane) {
    if (lane == lanes) break;
    const auto add_to = [&](BlockMatrix& matrix, double factor) {
      double* block = matrix.upper_block(places.values[lane]).data();
      for (int part = 0; part < 8 / lane_count; ++part)
        reinterpret_cast<materials::UnalignedLanes*>(block)[part] += factor * rows[part][lane];
      block[8] += factor * value.data()[8].values[lane];
    };
    add_to(into.matrix, 1.0);
    if (into.scaled != nullptr) add_to(*into.scaled, into.factor.values[lane]);
  }
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

// Adds the blocks of particles a and b to the upper blocks with the indices `places`. If a > b,
// adds the transpose. If a == b, adds the sum of the block and its transpose.
inline void add_pair_block(int lanes, const BlockBatch& value, const LaneIntegers& a,
                           const LaneIntegers& b, const LaneIntegers& places,
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
