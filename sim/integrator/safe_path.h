// The path of iterates towards an equilibrium, which must keep surfaces apart.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Checks the straight way from iterate to iterate with contact, and its end if membranes have a
// strain_limit. Otherwise every way is safe.
class SafePath {
 public:
  explicit SafePath(Dynamics& dynamics) : dynamics_(dynamics) {}

  // Starts at these positions of all particles (m) at a time (s). Without contact they may be
  // empty.
  void start(double time, const std::vector<Vec3>& positions) {
    time_ = time;
    from_ = positions;
  }
  // Moves to the state `y` at `time`. Returns the fault if the way there might let surfaces touch;
  // the path then stays where it was.
  [[nodiscard]] std::optional<ContactFault> move_to(double time, std::span<const double> y) {
    if (auto fault = dynamics_.check_limits(time, y)) return fault;
    if (dynamics_.contact() == nullptr) return std::nullopt;
    dynamics_.expand(time, y, to_, velocity_);
    if (auto fault = dynamics_.check_path(time_, from_, time, to_)) return fault;
    time_ = time;  // prescribed points have reached it
    from_.swap(to_);
    return std::nullopt;
  }

 private:
  Dynamics& dynamics_;
  double time_ = 0;  // s
  std::vector<Vec3> from_, to_, velocity_;
};

}  // namespace weft::sim
