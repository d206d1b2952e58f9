// The steps before which a simulation makes a checkpoint.
#pragma once

#include <optional>

#include "sim/base/state_archive.h"
#include "sim/case/case.h"

namespace weft::sim {

// Decides from steps and simulated times alone, so that every run of a case makes the same
// checkpoints (docs/decisions/0064). With output.checkpoint_every, a checkpoint is due at the end
// of the first step that reaches a multiple of it. Otherwise one is due after a number of steps
// that depends on the method.
class CheckpointSchedule {
 public:
  explicit CheckpointSchedule(const Case& source);

  // Counts a step.
  void add_step() { ++steps_; }
  // True if a checkpoint is due at `time` (s), the end of the last step.
  bool is_due(double time) const;
  // Notes that a checkpoint is made at `time` (s).
  void start(double time);
  void transfer(StateArchive& archive) { archive(steps_, last_time_); }

 private:
  std::optional<double> every_;  // output.checkpoint_every (s)
  int most_steps_;               // steps between two checkpoints if every_ is empty
  int steps_ = 0;                // steps since the last checkpoint
  double last_time_ = 0;         // time of the last checkpoint, or the start (s)
};

}  // namespace weft::sim
