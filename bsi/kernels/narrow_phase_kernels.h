// The inner loops of the narrow phase, one table per instruction set. An internal header of bsi/.
#pragma once

#include "bsi/leaf_pair.h"

namespace weft::bsi {

// The result of a comparison of the distance d of two triangles with the margin.
enum class Verdict : unsigned char {
  apart,      // d > margin, proved
  near,       // d <= margin, proved
  undecided,  // d is too close to the margin for the precision in use
};

// Pairs of triangles of two bodies. Positions are x, y, z (m) of every particle. Triangles are
// three particle indices each.
struct TrianglePairs {
  const double* positions_a;
  const int* triangles_a;
  const double* positions_b;
  const int* triangles_b;
  const LeafPair* pairs;
  int count;
};

struct NarrowPhaseKernels {
  // Judges every pair in float32. Precondition: `margin_low` <= margin <= `margin_high`.
  void (*judge)(const TrianglePairs& pairs, float margin_low, float margin_high, Verdict* verdict);
  // Judges every pair in float64 and computes its squared distance (m^2), which is 0 if the
  // triangles certainly pierce each other. certain[k] is true if squared distance k is proved
  // accurate within 1e-12 of itself.
  void (*measure)(const TrianglePairs& pairs, double margin, Verdict* verdict,
                  double* squared_distance, bool* certain);
};

// Returns the table for instruction_set().
const NarrowPhaseKernels& narrow_phase_kernels();

}  // namespace weft::bsi
