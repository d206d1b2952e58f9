// The inner loop of the narrow phase over pairs of leaf blocks, one table per instruction set. An
// internal header of bsi/.
#pragma once

#include "bsi/kernels/narrow_phase_kernels.h"
#include "bsi/leaf_pair.h"

namespace weft::bsi {

// Pairs of leaf blocks of two trees that are not swept.
struct JudgedBlocks {
  const BoxTree* a;
  const BoxTree* b;
  const LeafBlockPair* blocks;
  int count;
  bool self;  // true after a self traversal: the smaller index of a pair comes first
};

struct BlockJudgeKernels {
  // Lists the triangle pairs of the blocks in order, judges each from its float32 vertices, and
  // returns the number of pairs. Let e bound the change of a distance by the rounding of vertices.
  // Preconditions: `margin_low` is 0 or at most margin - e, and `margin_high` >= margin + e. May
  // write up to 16 pairs and verdicts past the end.
  int (*judge)(const JudgedBlocks& judged, float margin_low, float margin_high, LeafPair* pairs,
               Verdict* verdict);
  // Copies the pairs whose verdict is `wanted`, in order, and returns the number of copies. May
  // read verdicts and pairs, and write pairs, up to eight past the end.
  int (*select)(const LeafPair* pairs, const Verdict* verdict, int count, Verdict wanted,
                LeafPair* to);
};

// Returns the table for instruction_set().
const BlockJudgeKernels& block_judge_kernels();

}  // namespace weft::bsi
