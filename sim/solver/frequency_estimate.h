// An estimate of the highest eigenfrequency of the bodies.
#pragma once

#include <cstdint>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// Estimates the largest eigenvalue of M^-1 K, which changes little during a run. An estimate takes
// ten steps of the power method from a fixed random vector. It is reused for a hundred assemblies
// of K.
class FrequencyEstimate {
 public:
  explicit FrequencyEstimate(Dynamics& dynamics) : dynamics_(dynamics) {}

  // Returns the square root of the largest eigenvalue of M^-1 K on the free particles (1/s),
  // estimated from below. A new estimate costs ten products with K and ten solves with M.
  double highest();

  void transfer(StateArchive& archive) { archive(frequency_, assembly_); }

 private:
  Dynamics& dynamics_;
  double frequency_ = -1;      // 1/s; negative before the first estimate
  std::int64_t assembly_ = 0;  // number of assemblies of K at the last estimate
};

}  // namespace weft::sim
