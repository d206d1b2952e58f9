// The path of iterates towards an equilibrium, on which surfaces must stay apart.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Checks the path from iterate to iterate by Dynamics::check_path(), and its end if membranes have
// a strain_limit. Without both, every path is safe.
class SafePath {
 public:
  explicit SafePath(Dynamics& dynamics) : dynamics_(dynamics) {}

  // Starts the path at `positions` of all particles (m) at `time` (s). Without contact, `positions`
  // may be empty.
  void start(double time, const std::vector<Vec3>& positions) {
    time_ = time;
    from_ = positions;
  }
  // Extends the path to the state `y` at `time`. Returns the fault if surfaces might touch on the
  // way there; the path then does not change.
  [[nodiscard]] std::optional<ContactFault> move_to(double time, std::span<const double> y) {
    if (auto fault = dynamics_.check_limits(time, y)) return fault;
    if (dynamics_.contact() == nullptr) return std::nullopt;
    dynamics_.expand(time, y, to_, velocity_);
    if (auto fault = dynamics_.check_path(time_, from_, time, to_)) return fault;
    time_ = time;  // the next call starts with prescribed points of `time`
    from_.swap(to_);
    return std::nullopt;
  }

 private:
  Dynamics& dynamics_;
  double time_ = 0;  // s
  std::vector<Vec3> from_, to_, velocity_;
};

}  // namespace weft::sim
