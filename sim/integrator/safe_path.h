// The path of iterates towards an equilibrium, on which surfaces must stay apart.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Checks the path from each iterate to the next by Dynamics::check_path(), and the end of the path
// if membranes have a strain_limit. Without contact and strain_limit, every path is safe.
class SafePath {
 public:
  explicit SafePath(Dynamics& dynamics) : dynamics_(dynamics) {}

  // Starts the path at `positions` of all particles (m) at `time` (s). Without contact, `positions`
  // may be empty.
  void start(double time, const std::vector<Vec3>& positions) {
    time_ = time;
    from_ = positions;
  }
  // Extends the path to the state `y` at `time`. Returns a fault, and leaves the path unchanged, if
  // surfaces might touch on the extension.
  [[nodiscard]] std::optional<ContactFault> move_to(double time, std::span<const double> y) {
    if (auto fault = dynamics_.check_limits(time, y)) return fault;
    if (dynamics_.contact() == nullptr) return std::nullopt;
    dynamics_.expand(time, y, to_, velocity_);
    if (auto fault = dynamics_.check_path(time_, from_, time, to_)) return fault;
    time_ = time;  // prescribed points have reached `time`
    from_.swap(to_);
    return std::nullopt;
  }

 private:
  Dynamics& dynamics_;
  double time_ = 0;  // s
  std::vector<Vec3> from_, to_, velocity_;
};

}  // namespace weft::sim
