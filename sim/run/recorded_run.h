// One run of a case: from its scene to a trajectory file and a report.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/accuracy/error_estimate.h"
#include "sim/base/bill.h"
#include "sim/base/failure.h"
#include "sim/base/statistics.h"
#include "sim/case/case.h"

namespace weft::sim {

struct PilotReport;
struct Scene;

struct RunOptions {
  std::string trajectory;  // path of the HDF5 file; its folder is made where missing
  bool force = false;      // overwrite
  // Measure the error by a second, more exact run beside this one (sim/accuracy/error_monitor.h);
  // the trajectory then has a series error_estimate_BODY (m) a dynamic body. Not with `static`.
  bool estimate_error = false;
  // The bill before this call. Its report counts all of it, compute.cpu_limit the pilot.
  Bill earlier;
  // Called after every step with the simulated time (s). May be empty.
  std::function<void(double time)> progress;
  // Called before the run starts, with what the run decides by itself. May be empty.
  std::function<void(const std::string& text)> notice;
  // Set from outside (a signal) to stop after the current step. May be null.
  const std::atomic<int>* stop_signal = nullptr;
};

struct RunReport {
  enum class Status { done, failed, interrupted };
  Status status = Status::done;
  std::string reason;              // why it failed (what, which bodies, when) or was stopped
  std::optional<Failure> failure;  // where it failed; the reason is its text
  double simulated_time = 0;       // s; after a failure, of the last good state
  Bill bill;                       // with what was spent before
  int frames = 0;
  IntegratorCounts counts;
  std::optional<double> smallest_gap;  // m, in the last force evaluation of any step; nothing
                                       // when no pair ever came into reach
  std::string compute;         // what the contact search ran on, and why; empty without contact
  std::string decision;        // what the integrator decided by itself, last; empty for most
  double largest_stretch = 0;  // l / L - 1 over all frames and edges
  std::vector<std::pair<std::string, double>> energies;  // J, of the last frame, by series
  Statistics statistics;
  std::optional<ErrorEstimate> error_estimate;  // where asked for
  std::string trajectory;
};

// The status as the words of --json: "done", "failed", "interrupted".
const char* status_name(RunReport::Status status);

// Says why a run was interrupted by the signal that RunOptions::stop_signal holds.
std::string reason_of_signal(int signal);

// Runs to the end of the case, a failure or a stop; the trajectory then holds every frame so far,
// and after a failure the last good state as one frame more. Throws CaseError for an initial state
// that cannot be simulated and FileError when the file cannot be written; nothing is written
// in the first case.
RunReport run_simulation(const Scene& scene, const RunOptions& options);
// Settles time.accuracy first (accuracy_pilot.h), as `weft run` does.
RunReport run_simulation(Case source, const RunOptions& options);

// The report of a run that ended with its pilot, after `bill`.
RunReport ended_by_pilot(const PilotReport& pilot, const Bill& bill,
                         const std::atomic<int>* stop_signal);

}  // namespace weft::sim
