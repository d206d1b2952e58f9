#include "sim/integrator/veto_window.h"

#include <string>
#include <utility>

#include "sim/case/case_text.h"

namespace weft::sim {

void VetoWindow::add_veto(const std::optional<ContactFault>& fault) {
  ++vetoes_;
  last_fault_ = fault;
}

std::optional<std::int64_t> VetoWindow::add_step() {
  if (++steps_ < length) return std::nullopt;
  steps_ = 0;
  return std::exchange(vetoes_, 0);
}

Failure VetoWindow::failure(std::int64_t vetoes, double time, const char* remedy,
                            const Scene& scene) const {
  const bool is_stretched = last_fault_ && last_fault_->kind == ContactFault::Kind::overstretched;
  return {Failure::Kind::too_many_cuts, time, last_fault_ ? last_fault_->particle(scene) : -1,
          number_text(static_cast<double>(vetoes)) + " steps had to be cut in the last " +
              number_text(length) + " to keep " +
              (is_stretched ? "membranes within their limit" : "surfaces apart") +
              " at t = " + rounded_text(time) + " s" +
              (last_fault_ ? ": " + last_fault_->describe(scene) : "") + " (" +
              (is_stretched ? "time.step or the tolerances are too large for this strain_limit"
                            : remedy) +
              ", or a prescribed motion leaves no room)"};
}

}  // namespace weft::sim
