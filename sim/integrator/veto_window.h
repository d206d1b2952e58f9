// Counts the steps that contact cuts, in order to end runs that hardly advance.
#pragma once

#include <cstdint>
#include <optional>

#include "sim/base/failure.h"
#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// Counts vetoes over windows of accepted steps. A healthy run almost never cuts a step because of
// contact; a run that often does would take too long to end (docs/decisions/0010).
class VetoWindow {
 public:
  static constexpr int length = 200;  // accepted steps

  // Counts a step that was cut because of this fault.
  void add_veto(const std::optional<ContactFault>& fault);
  // Counts an accepted step. At the end of a window, returns its number of vetoes; otherwise
  // nothing.
  std::optional<std::int64_t> add_step();
  // Returns the failure of a run with this many vetoes in the last window. It names the last fault,
  // although a later, shorter step has passed. `remedy` says which option of the case may be wrong.
  Failure failure(std::int64_t vetoes, double time, const char* remedy, const Scene& scene) const;

  void transfer(StateArchive& archive) { archive(steps_, vetoes_, last_fault_); }

 private:
  int steps_ = 0;            // of the present window
  std::int64_t vetoes_ = 0;  // in the present window
  std::optional<ContactFault> last_fault_;
};

}  // namespace weft::sim
