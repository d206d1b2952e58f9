// A guard for tests that change OpenMP's number of threads or the instruction set.
#pragma once

#include <omp.h>

#include "bsi/detail/instruction_set.h"

namespace weft::bsi {

// Restores both at the end of its scope.
class RestoredSettings {
 public:
  RestoredSettings() = default;
  RestoredSettings(const RestoredSettings&) = delete;
  RestoredSettings& operator=(const RestoredSettings&) = delete;
  ~RestoredSettings() {
    omp_set_num_threads(threads_);
    use_instruction_set(set_);
  }

 private:
  int threads_ = omp_get_max_threads();
  InstructionSet set_ = instruction_set();
};

}  // namespace weft::bsi
