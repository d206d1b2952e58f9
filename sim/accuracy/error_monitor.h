// Measures the error of a run in progress by a second, more exact run.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/accuracy/error_estimate.h"
#include "sim/base/state_archive.h"
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
// `euler` without a fixed step is of order 1, and does not obey this law at loose tolerances, so
// `cvode` replaces it. Fixed steps become an eighth for `euler`, which divides the error by 8. They
// become a quarter for methods of order 2, which divides the error by 16. Precondition: the method
// is not `static`, which has no error of time steps.
TimeCase tightened(const TimeCase& time);

// Compares a run, frame by frame, with a second, more exact run. It stores only one state of the
// second run. A second run that gains energy counts as failed.
class ErrorMonitor {
 public:
  // Uses tightened() options for the second run. A nonzero value at `stop` ends that run. `stop`
  // may be null; otherwise the value must outlive the monitor.
  ErrorMonitor(const Scene& scene, const std::atomic<int>* stop);
  // A function that is called before every step of the second run. It returns true to end that run.
  // May be empty.
  using ShouldStop = std::function<bool(const Simulation& second)>;
  // Uses `second` as the options of the second, more exact run.
  ErrorMonitor(const Scene& scene, const TimeCase& second, ShouldStop should_stop);

  // Advances the second run to `time` (s), and compares its state with the state `y` of the first
  // run. Precondition: `time` is not before the `time` of the last call. Returns the RMS distance
  // (m) for each dynamic body, or NaN if the second run has failed or was stopped.
  std::span<const double> compare(double time, std::span<const double> y);
  ErrorEstimate estimate() const;

  // checkpoint() returns the monitor as bytes, and restore() continues from them, as those of
  // Simulation do. restore() throws std::invalid_argument for other bytes.
  std::string checkpoint();
  void restore(std::string_view bytes);

 private:
  void transfer(StateArchive& archive, std::string& simulation);
  bool advance(double time);
  void measure(double time);

  Simulation simulation_;
  ShouldStop should_stop_;
  std::vector<double> state_;
  std::vector<Vec3> position_, other_position_, scratch_velocity_;
  std::vector<double> distances_;        // RMS distances of the last frame by body, m
  std::vector<double> motion_, radius_;  // by body: largest RMS motion so far; RMS radius; m
  std::vector<double> times_;            // times of the frames compared, s
  std::vector<double> all_distances_;    // RMS distances by frame, then by body, m
  std::string failure_;
};

}  // namespace weft::sim
