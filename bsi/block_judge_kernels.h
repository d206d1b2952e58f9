// The inner loop of the narrow phase over pairs of leaf blocks, one table for every instruction
// set. An internal header of bsi/.
#pragma once

#include "bsi/leaf_pair.h"
#include "bsi/narrow_phase_kernels.h"

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
  // The pairs of the blocks in their order, and what is known of each from the vertices in float32,
  // which the margins must allow for: `margin_low` <= margin - e and margin_high >= margin + e,
  // where e is how much nearer or farther the float64 vertices can make them. Returns the number of
  // pairs. May write 16 more.
  int (*judge)(const JudgedBlocks& judged, float margin_low, float margin_high, LeafPair* pairs,
               Verdict* verdict);
  // Those of the pairs that have a verdict, in their order; their number. May read verdicts and
  // pairs and write pairs eight past the end.
  int (*select)(const LeafPair* pairs, const Verdict* verdict, int count, Verdict wanted,
                LeafPair* to);
};

// Of instruction_set().
const BlockJudgeKernels& block_judge_kernels();

}  // namespace weft::bsi
