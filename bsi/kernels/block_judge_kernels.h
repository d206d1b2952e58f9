// The inner loop of the narrow phase over pairs of leaf blocks, one table for every instruction
// set. An internal header of bsi/.
#pragma once

#include "bsi/kernels/narrow_phase_kernels.h"
#include "bsi/leaf_pair.h"

namespace weft::bsi {

// Pairs of triangles of two trees that are not swept.
struct JudgedBlocks {
  const BoxTree* a;
  const BoxTree* b;
  const LeafBlockPair* blocks;
  int count;
  bool self;  // the smaller number of a pair goes first
};

struct BlockJudgeKernels {
  // Lists the pairs of the blocks in their order and judges each from the vertices in float32. The
  // margins must allow for e, by which the float64 vertices can be nearer or farther: `margin_low`
  // <= margin - e and `margin_high` >= margin + e. Returns the number of pairs. May write 16 more.
  int (*judge)(const JudgedBlocks& judged, float margin_low, float margin_high, LeafPair* pairs,
               Verdict* verdict);
  // Copies the pairs whose verdict is `wanted` in their order and returns their number. May read
  // verdicts and pairs and write pairs eight past the end.
  int (*select)(const LeafPair* pairs, const Verdict* verdict, int count, Verdict wanted,
                LeafPair* to);
};

// Returns the table for instruction_set().
const BlockJudgeKernels& block_judge_kernels();

}  // namespace weft::bsi
