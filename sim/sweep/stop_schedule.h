// When an engine whose time runs out stops its runs.
#pragma once

#include <chrono>
#include <optional>

namespace weft::sim {

// First no further run begins, and runs end at their next checkpoint, so that nothing is computed
// twice. Runs whose next checkpoint does not come in time are stopped where they are.
class StopSchedule {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Phase { running, last_checkpoints, stopping };

  // The engine must have ended at `end`, if that is known. The last tenth of the time from `now` on
  // is kept for stopping, at least 2 s and at most 90 s; half of it is left to checkpoints.
  StopSchedule(std::optional<Clock::time_point> end, Clock::time_point now);

  // Learns by a signal that at least a minute is left, of which half is left to checkpoints. An end
  // that is known is more exact, and the signal is then ignored.
  void heed_notice(Clock::time_point now);

  Phase phase(Clock::time_point now) const;

 private:
  bool knows_end_;
  std::optional<Clock::time_point> last_checkpoints_, stop_;  // times at which these phases begin
};

}  // namespace weft::sim
