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
  std::string trajectory;  // path of the HDF5 file; a missing folder is created
  bool force = false;      // overwrites an existing file
  // Measures the error by a second, more exact run beside this one (sim/accuracy/error_monitor.h).
  // The trajectory then has a series error_estimate_BODY (m) per dynamic body. Not allowed with
  // method `static`.
  bool estimate_error = false;
  // Costs before this call: set-up, pilot and their total. The report's bill includes them, and
  // compute.cpu_limit counts the pilot.
  Bill earlier;
  // Called after every step with the simulated time (s). May be empty.
  std::function<void(double time)> progress;
  // Called with each choice that the run makes by itself, before and during the run. May be empty.
  std::function<void(const std::string& text)> notice;
  // A nonzero value stops the run after the current step. A signal handler may set it. May be null.
  const std::atomic<int>* stop_signal = nullptr;
};

struct RunReport {
  enum class Status { done, failed, interrupted };
  Status status = Status::done;
  std::string reason;              // why the run failed (fault, bodies, time) or was stopped
  std::optional<Failure> failure;  // set after a failure; the reason is its text
  double simulated_time = 0;       // s; after a failure, time of the last good state
  Bill bill;                       // includes RunOptions::earlier
  int frames = 0;
  IntegratorCounts counts;
  // The smallest gap (m) in any step's last force evaluation; empty if no pair came into reach.
  std::optional<double> smallest_gap;
  std::string compute;         // device of the contact search, and why; empty without contact
  std::string decision;        // last choice that the integrator made by itself; often empty
  double largest_stretch = 0;  // l / L - 1 over all frames and edges
  std::vector<std::pair<std::string, double>> energies;  // J, by name; of the last frame
  Statistics statistics;
  std::optional<ErrorEstimate> error_estimate;  // if requested
  std::string trajectory;
};

// Returns the status as --json writes it: "done", "failed", "interrupted".
const char* status_name(RunReport::Status status);

// Returns the reason to report for a run that this signal (RunOptions::stop_signal) interrupted.
std::string reason_of_signal(int signal);

// Runs to the end of the case, a failure or a stop. The trajectory then holds every frame up to
// that time and, after a failure, the last good state as an additional frame. Throws CaseError for
// an initial state that cannot be simulated, before any file is written. Throws FileError if the
// file cannot be written.
RunReport run_simulation(const Scene& scene, const RunOptions& options);
// Settles time.accuracy first, as `weft run` does (accuracy_pilot.h).
RunReport run_simulation(Case source, const RunOptions& options);

// Returns the report of a run that its pilot ended. `bill` holds the costs up to then.
RunReport ended_by_pilot(const PilotReport& pilot, const Bill& bill,
                         const std::atomic<int>* stop_signal);

}  // namespace weft::sim
