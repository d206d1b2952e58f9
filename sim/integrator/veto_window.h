// Counts the trial steps that contact rejects, in order to end runs that hardly advance.
#pragma once

#include <cstdint>
#include <optional>

#include "sim/base/failure.h"
#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// Counts vetoes over windows of accepted steps. A veto is a trial step rejected because of contact.
// Vetoes are rare in a healthy run; a run with many would take too long to end
// (docs/decisions/0010).
class VetoWindow {
 public:
  static constexpr int length = 200;  // accepted steps per window

  // Counts a veto. `fault` is its cause.
  void add_veto(const std::optional<ContactFault>& fault);
  // Counts an accepted step. Returns the number of vetoes of the window if this step completes it,
  // otherwise nothing.
  std::optional<std::int64_t> add_step();
  // Returns the failure of a run with this many vetoes in the last window. The text names the fault
  // of the last veto. `remedy` says which option of the case may be wrong.
  Failure failure(std::int64_t vetoes, double time, const char* remedy, const Scene& scene) const;

  void transfer(StateArchive& archive) { archive(steps_, vetoes_, last_fault_); }

 private:
  int steps_ = 0;            // accepted steps in the present window
  std::int64_t vetoes_ = 0;  // vetoes in the present window
  std::optional<ContactFault> last_fault_;
};

}  // namespace weft::sim
