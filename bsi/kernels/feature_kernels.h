// The inner loops over vertex-triangle and edge-edge pairs, one table per instruction set. An
// internal header of bsi/.
#pragma once

namespace weft::bsi {

// Pairs of features, with four particles per pair. `positions` holds x, y, z of every particle, m.
struct FeatureBatch {
  const double* positions;
  const double* paths;  // m, path length of every particle; null: all are 0
  const int (*particles)[4];
  int count;
};

// Every member has one function per kind: vertex-triangle, edge-edge.
struct FeatureKernels {
  // Finds, in float32, the pairs whose distance is certain to exceed `reach` plus twice the longest
  // path of the four particles.
  void (*find_apart[2])(const FeatureBatch& batch, float reach, bool* apart);
  // Computes, in float64, the squared distance (m^2) and twice the longest path (m). `certain` is
  // true if the squared distance is proved accurate within 1e-12 of itself.
  void (*measure[2])(const FeatureBatch& batch, double* squared_distance, bool* certain,
                     double* path);
  // Finds, in float32, the pairs that are certainly safe on straight paths to the positions `end`.
  // Their distance stays above `separation`, and ends above `end_separation` (>= `separation`).
  void (*find_safe[2])(const FeatureBatch& batch, const double* end, float separation,
                       float end_separation, bool* safe);
};

// Returns the table for instruction_set().
const FeatureKernels& feature_kernels();

}  // namespace weft::bsi
