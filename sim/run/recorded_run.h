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
  bool force = false;      // overwrite
  // Measures the error by a second, more exact run beside this one (sim/accuracy/error_monitor.h).
  // The trajectory then has a series error_estimate_BODY (m) per dynamic body. Not with `static`.
  bool estimate_error = false;
  // The bill before this call. The report includes all of it; compute.cpu_limit counts its pilot.
  Bill earlier;
  // Called after every step with the simulated time (s). May be empty.
  std::function<void(double time)> progress;
  // Called before the run starts, with the choices that the run makes by itself. May be empty.
  std::function<void(const std::string& text)> notice;
  // Set from outside (by a signal) to stop after the current step. May be null.
  const std::atomic<int>* stop_signal = nullptr;
};

struct RunReport {
  enum class Status { done, failed, interrupted };
  Status status = Status::done;
  std::string reason;              // why it failed (fault, bodies, time) or was stopped
  std::optional<Failure> failure;  // set after a failure; the reason is its text
  double simulated_time = 0;       // s; after a failure, of the last good state
  Bill bill;                       // including RunOptions::earlier
  int frames = 0;
  IntegratorCounts counts;
  // The smallest gap (m) in any step's last force evaluation; empty if no pair came into reach.
  std::optional<double> smallest_gap;
  std::string compute;   // device of the contact search, with the reason; empty without contact
  std::string decision;  // last choice that the integrator made by itself; mostly empty
  double largest_stretch = 0;                            // l / L - 1 over all frames and edges
  std::vector<std::pair<std::string, double>> energies;  // J, of the last frame, by series
  Statistics statistics;
  std::optional<ErrorEstimate> error_estimate;  // if asked for
  std::string trajectory;
};

// The status as the words of --json: "done", "failed", "interrupted".
const char* status_name(RunReport::Status status);

// The reason of a run that the signal in RunOptions::stop_signal interrupted.
std::string reason_of_signal(int signal);

// Runs to the end of the case, a failure or a stop. The trajectory then holds every frame so far
// and, after a failure, the last good state as an additional frame. Throws CaseError for an initial
// state that cannot be simulated, before anything is written, and FileError if the file cannot be
// written.
RunReport run_simulation(const Scene& scene, const RunOptions& options);
// Settles time.accuracy first (accuracy_pilot.h), as `weft run` does.
RunReport run_simulation(Case source, const RunOptions& options);

// The report of a run that its pilot ended; `bill` is the bill so far.
RunReport ended_by_pilot(const PilotReport& pilot, const Bill& bill,
                         const std::atomic<int>* stop_signal);

}  // namespace weft::sim
