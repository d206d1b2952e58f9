// The highest frequency of the bodies, which decides between preconditioners.
#pragma once

#include <cstdint>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// The largest eigenvalue of K changes little. It is estimated once per hundred assemblies, by ten
// steps of the power method from a fixed random vector.
class FrequencyEstimate {
 public:
  explicit FrequencyEstimate(Dynamics& dynamics) : dynamics_(dynamics) {}

  // Returns the square root of the largest eigenvalue of M^-1 K on the free particles (1/s),
  // estimated from below.
  double highest();

  void transfer(StateArchive& archive) { archive(frequency_, assembly_); }

 private:
  Dynamics& dynamics_;
  double frequency_ = -1;      // 1/s; negative before the first estimate
  std::int64_t assembly_ = 0;  // the assembly of K that it was estimated from
};

}  // namespace weft::sim
