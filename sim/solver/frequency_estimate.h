// The highest frequency of the bodies, as it decides between preconditioners.
#pragma once

#include <cstdint>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// The largest eigenvalue of K hardly changes: it is estimated once in a hundred assemblies, by ten
// steps of the power method from a fixed random vector.
class FrequencyEstimate {
 public:
  explicit FrequencyEstimate(Dynamics& dynamics) : dynamics_(dynamics) {}

  // sqrt of the largest eigenvalue of M^-1 K on the free particles (1/s), from below.
  double highest();

  void transfer(StateArchive& archive) { archive(frequency_, assembly_); }

 private:
  Dynamics& dynamics_;
  double frequency_ = -1;      // 1/s; negative before the first estimate
  std::int64_t assembly_ = 0;  // of K, from which it was estimated
};

}  // namespace weft::sim
