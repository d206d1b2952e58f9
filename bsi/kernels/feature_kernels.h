// The inner loops over vertex-triangle and edge-edge pairs, one table per instruction set. An
// internal header of bsi/.
#pragma once

namespace weft::bsi {

// Pairs of features, with four particles per pair.
struct FeatureBatch {
  const double* positions;  // x, y, z of every particle, m
  const int (*particles)[4];
  int count;
};

// The kernels for pairs of features. Each member has two functions, for vertex-triangle and for
// edge-edge pairs.
struct FeatureKernels {
  // Sets apart[k] to true if the distance of pair k certainly exceeds `reach`. Computes in float32.
  void (*find_apart[2])(const FeatureBatch& batch, float reach, bool* apart);
  // Computes, in float64, the squared distance (m^2) of each pair. certain[k] is true if squared
  // distance k is proved accurate within 1e-12 of itself.
  void (*measure[2])(const FeatureBatch& batch, double* squared_distance, bool* certain);
  // Sets safe[k] to true if pair k is certainly safe on straight paths to the positions `end`. Its
  // distance then stays above `separation`, and ends above `end_separation` (m, >= `separation`).
  // Computes in float32.
  void (*find_safe[2])(const FeatureBatch& batch, const double* end, float separation,
                       float end_separation, bool* safe);
  // Computes a lower bound (m) of the distance of each pair on the straight paths to the positions
  // `end`, in float32.
  void (*bound_paths[2])(const FeatureBatch& batch, const double* end, float* distance);
};

// Returns the table for instruction_set().
const FeatureKernels& feature_kernels();

}  // namespace weft::bsi
