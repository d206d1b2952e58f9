#include "sim/simulation/checkpoint_schedule.h"

#include <cmath>

#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

// Numbers of steps between two checkpoints (docs/decisions/0064). A checkpoint costs about as much
// as ten steps of a method that restarts there, and less with other methods. The steps of explicit
// methods are short, those of equilibria long.
constexpr int steps_of_implicit = 500, steps_of_explicit = 5000, steps_of_equilibria = 10;

int steps_between_checkpoints(const TimeMethodTraits& method) {
  if (method.finds_equilibria()) return steps_of_equilibria;
  return method.is_explicit ? steps_of_explicit : steps_of_implicit;
}

}  // namespace

CheckpointSchedule::CheckpointSchedule(const Case& source)
    : every_(source.output.checkpoint_every),
      most_steps_(steps_between_checkpoints(traits_of(source.time.method))) {}

bool CheckpointSchedule::is_due(double time) const {
  if (!every_) return steps_ >= most_steps_;
  return std::floor(time / *every_) > std::floor(last_time_ / *every_);
}

void CheckpointSchedule::start(double time) {
  steps_ = 0;
  last_time_ = time;
}

}  // namespace weft::sim
