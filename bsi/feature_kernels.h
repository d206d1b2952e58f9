// The inner loops over vertex-triangle and edge-edge pairs, one table for every instruction set. An
// internal header of bsi/.
#pragma once

namespace weft::bsi {

// Pairs of features: four particles each, and x, y, z of every particle.
struct FeatureBatch {
  const double* positions;
  const double* paths;  // how far every particle may be from there, m; null: nowhere else
  const int (*particles)[4];
  int count;
};

// The members are by kind: vertex-triangle, edge-edge.
struct FeatureKernels {
  // In float32: is the distance certain to be above `reach` plus twice the longest path of the four
  // particles?
  void (*find_apart[2])(const FeatureBatch& batch, float reach, bool* apart);
  // In float64: the squared distance, whether that is known to be right within rounding (1e-12 of
  // itself), and twice the longest path.
  void (*measure[2])(const FeatureBatch& batch, double* squared_distance, bool* certain,
                     double* path);
  // In float32: on straight paths to the positions `end`, is the distance certain to stay above
  // `separation`, and to be above `end_separation`, no less, at the end?
  void (*find_safe[2])(const FeatureBatch& batch, const double* end, float separation,
                       float end_separation, bool* safe);
};

// Of instruction_set().
const FeatureKernels& feature_kernels();

}  // namespace weft::bsi
