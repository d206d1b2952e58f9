// The count of steps cut because of contact, which ends runs that creep.
#pragma once

#include <cstdint>
#include <optional>

#include "sim/base/failure.h"
#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// Counts vetoes over windows of accepted steps. A healthy run hardly ever cuts a step because of
// contact; one that keeps doing so creeps on without end (docs/decisions/0010).
class VetoWindow {
 public:
  static constexpr int length = 200;  // accepted steps

  // Counts a step that was cut because of this fault.
  void add_veto(const std::optional<ContactFault>& fault);
  // Counts an accepted step. Returns the number of vetoes in the window that ends with it; empty
  // within a window.
  std::optional<std::int64_t> add_step();
  // The failure of a run with so many vetoes in the last window. It names the last fault, although
  // a step found a way past that. `remedy`: what may be wrong with the case.
  Failure failure(std::int64_t vetoes, double time, const char* remedy, const Scene& scene) const;

  void transfer(StateArchive& archive) { archive(steps_, vetoes_, last_fault_); }

 private:
  int steps_ = 0;            // of this window
  std::int64_t vetoes_ = 0;  // in this window
  std::optional<ContactFault> last_fault_;
};

}  // namespace weft::sim
