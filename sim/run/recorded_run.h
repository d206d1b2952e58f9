// A recorded run of a case, which produces a trajectory file and a report.
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
struct RunCheckpoint;
struct Scene;

struct RunOptions {
  std::string trajectory;  // path of the HDF5 file; a missing folder is created
  bool force = false;      // overwrites an existing file
  // If true, run_simulation(Case) goes on from the checkpoint of an earlier run of the same case,
  // as find_resumption() finds it (resumption.h). Without a checkpoint it begins at t = 0, in place
  // of the file of that run. Frames, steps and series then have the bits of a run that was never
  // stopped, apart from clocks.
  bool resume = false;
  // The checkpoint from which run_simulation(Scene) goes on; it must outlive the call. Null: the
  // run begins at t = 0.
  const RunCheckpoint* resumed = nullptr;
  // motion_text() of the case before time.accuracy has chosen, for checkpoints. Empty: that of the
  // scene's case.
  std::string case_text;
  // If true, a second, more exact run beside this one measures the error
  // (sim/accuracy/error_monitor.h). The trajectory then has a series error_estimate_BODY (m) per
  // dynamic body. Not allowed with method `static`.
  bool estimate_error = false;
  // Costs before run_simulation(): set-up, pilot and their total. The report's bill includes them.
  // The pilot's CPU time also counts towards compute.cpu_limit.
  Bill earlier;
  // Is called with the simulated time (s) after every step that succeeds, steps of a pilot
  // included. The function may be empty.
  std::function<void(double time)> progress;
  // Is called with a description of each choice that the run makes by itself. The function may be
  // empty.
  std::function<void(const std::string& text)> notice;
  // Is called with each warning that the run is not what the case seems to ask for. The function
  // may be empty.
  std::function<void(const std::string& text)> warning;
  // A nonzero value asks the run to stop; the run then ends at the latest after the current step. A
  // signal handler may set the value. The pointer may be null.
  const std::atomic<int>* stop_signal = nullptr;
  // A nonzero value asks the run to stop at its next checkpoint. A run that goes on from there
  // computes no step again. A signal handler may set the value. The pointer may be null.
  const std::atomic<int>* stop_at_checkpoint = nullptr;
};

struct RunReport {
  enum class Status { done, failed, interrupted };
  Status status = Status::done;
  std::string reason;                // reason of a failure or a stop, in words; else empty
  std::optional<Failure> failure;    // set after a failure; `reason` is then its text
  double simulated_time = 0;         // s; after a failure, the time of the last good state
  std::optional<double> resumed_at;  // time of the checkpoint from which the run went on (s)
  Bill bill;  // includes RunOptions::earlier, and costs before the checkpoint
  int frames = 0;
  IntegratorCounts counts;
  // Smallest gap (m) over all steps, each at its last force evaluation. Empty if no pair came into
  // reach.
  std::optional<double> smallest_gap;
  std::string compute;   // device of the contact search and its reason; empty without contact
  std::string decision;  // last choice that the integrator made by itself; empty without a choice
  double largest_stretch = 0;  // largest l / L - 1 over all frames and edges
  std::vector<std::pair<std::string, double>> energies;  // energies (J) of the last frame, by name
  // Values of the case's [outputs], in their order; NaN for what does not exist.
  std::vector<std::pair<std::string, double>> outputs;
  Statistics statistics;
  std::optional<ErrorEstimate> error_estimate;  // set if RunOptions::estimate_error
  std::string trajectory;                       // path of the HDF5 file
};

// Returns the status as --json writes it: "done", "failed", "interrupted".
const char* status_name(RunReport::Status status);

// Returns RunReport::reason for a run that a signal interrupted. `signal` is the value of
// RunOptions::stop_signal.
std::string reason_of_signal(int signal);

// Runs the scene until the end of the case, a failure or a stop. The trajectory then holds all
// frames up to that time. After a failure, its last frame is the last good state. Throws CaseError
// for an initial state that cannot be simulated and for outputs at fault, before any file is
// written. Throws FileError if
// the file cannot be written.
RunReport run_simulation(const Scene& scene, const RunOptions& options);
// Runs the case in the same way. If the case gives time.accuracy, correct_accuracy() first chooses
// the method and its settings (sim/accuracy/accuracy_pilot.h).
RunReport run_simulation(Case source, const RunOptions& options);

// Returns the report of a run that ended during its pilot. `bill` holds the costs so far.
// `stop_signal` is RunOptions::stop_signal; it must not be null if the pilot was interrupted.
RunReport ended_by_pilot(const PilotReport& pilot, const Bill& bill,
                         const std::atomic<int>* stop_signal);

}  // namespace weft::sim
