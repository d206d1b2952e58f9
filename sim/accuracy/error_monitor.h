// Measures the error of a run in progress by a second, more exact run.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/accuracy/error_estimate.h"
#include "sim/scene/scene.h"
#include "sim/simulation/simulation.h"

namespace weft::sim {

// Returns the root mean square distance (m) between corresponding points of two lists of equal
// length.
double rms_distance(std::span<const Vec3> a, std::span<const Vec3> b);

// Returns the options of a run with a much smaller error than a run with `time`.
//
// Tolerances become a 64th. For a method of order p under error control, steps are proportional to
// the (p + 1)-th root of the tolerance, and errors to the p-th power of the steps. With p = 2,
// steps become a quarter and errors a 16th. Source: Hairer, Noersett, Wanner, Solving Ordinary
// Differential Equations I, II.4.
//
// `euler` without a fixed step is of order 1, and far from this law at loose tolerances, so `cvode`
// replaces it. Fixed steps become an eighth (euler) or a quarter (order 2). That leaves an eighth
// or a 16th of the error. Precondition: the method is not `static`, which has no error of time
// steps.
TimeCase tightened(const TimeCase& time);

// Compares a run, frame by frame, with a second run. Holds one state of the second run and no
// trajectory. A second run that gains energy counts as failed.
class ErrorMonitor {
 public:
  // A nonzero `stop` ends the second run early. `stop` may be null, and must outlive the monitor.
  ErrorMonitor(const Scene& scene, const std::atomic<int>* stop);
  // A function that is called after every step of the second run. It returns true to end that run
  // early. May be empty.
  using ShouldStop = std::function<bool(const Simulation& second)>;
  // Uses `second` as the options of the second, more exact run.
  ErrorMonitor(const Scene& scene, const TimeCase& second, ShouldStop should_stop);

  // Advances the second run to `time` (s), and compares its state with the state `y` of the first.
  // Precondition: `time` is not before that of the last call. Returns the RMS distances by dynamic
  // body (m), or NaN if the second run has failed or was stopped.
  std::span<const double> compare(double time, std::span<const double> y);
  ErrorEstimate estimate() const;

 private:
  bool advance(double time);
  void measure(double time);

  Simulation simulation_;
  ShouldStop should_stop_;
  std::vector<double> state_;
  std::vector<Vec3> position_, other_position_, scratch_velocity_;
  std::vector<double> distances_;        // m, by body
  std::vector<double> motion_, radius_;  // m, by body: largest motion so far; initial radius
  std::vector<double> times_;            // s, of the frames compared
  std::vector<double> all_distances_;    // m, by frame and body
  std::string failure_;
};

}  // namespace weft::sim
