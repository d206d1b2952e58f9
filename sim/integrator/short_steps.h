// Steps that are shorter than time.minimum_step.
#pragma once

#include <algorithm>

#include "sim/base/state_archive.h"
#include "sim/case/case.h"

namespace weft::sim {

// The steps of a run that are shorter than minimum_step. A run may take up to a hundred of them,
// and as many more as it takes others. Surfaces that start deep within contact.range, that a jump
// releases or that meet fast are thrown apart, and the steps of this moment are much shorter than
// those that follow (docs/decisions/0106).
class ShortSteps {
 public:
  // `time` must outlive the object.
  explicit ShortSteps(const TimeCase& time) : time_(time) {}

  // Returns the shortest length (s) that any step may have: a thousandth of minimum_step.
  static double shortest_ever(const TimeCase& time) { return 1e-3 * time.minimum_step; }

  // To be called after each accepted step, with its length (s).
  void note(double length) {
    left_ = length < time_.minimum_step ? std::max(left_ - 1, 0) : std::min(left_ + 1, most);
  }
  bool are_allowed() const { return left_ > 0; }
  // Returns the shortest length (s) that the next step may have.
  double shortest() const { return are_allowed() ? shortest_ever(time_) : time_.minimum_step; }
  void transfer(StateArchive& archive) { archive(left_); }

 private:
  static constexpr int most = 100;

  const TimeCase& time_;
  int left_ = most;
};

}  // namespace weft::sim
