// Numbers that belong to the stencils of an array, compressed.
#pragma once

#include <algorithm>
#include <vector>

#include "materials/lanes.h"

namespace weft::sim {

// One number per stencil. Equal numbers of consecutive stencils are stored once, as a run.
class StencilNumbers {
 public:
  // Appends the number of the next stencil.
  void push_back(double value) {
    ++count_;
    if (runs_.empty() || runs_.back().value != value) runs_.push_back({count_, value});
    runs_.back().end = count_;
  }

  // Appends `value` for each of the next `count` stencils.
  void append(int count, double value) {
    if (count == 0) return;
    push_back(value);
    count_ += count - 1;
    runs_.back().end = count_;
  }

  // Returns the numbers of the stencils from `first` on, one per lane. Lanes beyond the last
  // stencil are zero. O(log runs).
  materials::Lanes batch(int first) const {
    auto run = std::upper_bound(runs_.begin(), runs_.end(), first,
                                [](int stencil, const Run& r) { return stencil < r.end; });
    if (run != runs_.end() && first + materials::lane_count <= run->end) return run->value;
    materials::Lanes values = 0;
    for (int lane = 0; lane < materials::lane_count && run != runs_.end(); ++lane) {
      values.values[lane] = run->value;
      if (first + lane + 1 == run->end) ++run;
    }
    return values;
  }

 private:
  struct Run {
    int end = 0;  // index of the first stencil after the run
    double value = 0;
  };
  std::vector<Run> runs_;
  int count_ = 0;
};

}  // namespace weft::sim
