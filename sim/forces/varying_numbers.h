// Coefficients of stencils that may vary in time.
#pragma once

#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "sim/matrix/stencil_numbers.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

// The coefficients of all stencils of an array. Each append() adds a run of stencils with one
// common coefficient.
class VaryingNumbers {
 public:
  using Coefficient = std::function<double(const Instant&)>;

  // Appends a run of `count` stencils. A coefficient that does not vary is evaluated here, and
  // never again.
  void append(int count, bool varies, Coefficient coefficient) {
    varies_ |= varies;
    end_ += count;
    runs_.push_back({end_, varies, std::move(coefficient)});
    if (!varies) runs_.back().value = runs_.back().coefficient({});
  }
  void append(int count, const Varying<double>& source) {
    const TimeCurve<double> curve(source);
    append(count, curve.varies(), [curve](const Instant& now) { return curve.at(now); });
  }

  bool varies() const { return varies_; }
  // Calls visit(first, last, coefficient) for each run whose coefficient has changed since the last
  // call of visit_changed() or update(). The first call visits all runs that vary. The run consists
  // of the stencils first .. last - 1.
  template <class Visit>
  void visit_changed(const Instant& now, const Visit& visit) {
    int first = 0;
    for (Run& run : runs_) {
      if (run.varies) {
        const double value = run.coefficient(now);
        if (value != run.value) visit(first, run.end, value);
        run.value = value;
      }
      first = run.end;
    }
  }
  // Sets `target` to the coefficients at `now` if visit_changed() would visit a run.
  void update(const Instant& now, StencilNumbers& target) {
    bool changed = false;
    visit_changed(now, [&](int, int, double) { changed = true; });
    if (changed) target = numbers();
  }
  // Returns the coefficients at the time of the last visit_changed() or update(). Before the first
  // call of either, varying coefficients are NaN.
  StencilNumbers numbers() const {
    StencilNumbers numbers;
    int first = 0;
    for (const Run& run : runs_) {
      numbers.append(run.end - first, run.value);
      first = run.end;
    }
    return numbers;
  }

 private:
  struct Run {
    int end = 0;  // one past the run's last stencil
    bool varies = false;
    Coefficient coefficient;
    double value = std::numeric_limits<double>::quiet_NaN();
  };
  std::vector<Run> runs_;
  int end_ = 0;
  bool varies_ = false;
};

}  // namespace weft::sim
