// Chooses the method and the tolerances for time.accuracy by pilot runs.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "sim/base/bill.h"
#include "sim/case/case.h"

namespace weft::sim {

struct PilotOptions {
  // `notice` is called before each stage of the pilot with a description. `progress` is called
  // during a stage with the simulated time it has reached (s, up to the duration). Both functions
  // may be empty.
  std::function<void(const std::string& text)> notice;
  std::function<void(double time)> progress;
  // If not null, a nonzero value at this address stops the pilot after the current step. A signal
  // handler may set it.
  const std::atomic<int>* stop_signal = nullptr;
};

struct PilotReport {
  Cost cost;
  // `interrupted` is set if the stop signal ended the pilot, `limit_reason` if compute.cpu_limit
  // did. The pilot has then corrected nothing, and the case must not be run.
  bool interrupted = false;
  std::string limit_reason;
  bool ended_run() const { return interrupted || !limit_reason.empty(); }
};

// Chooses the method and the tolerances for `time.accuracy`. It first chooses by the table
// (choose_accuracy()). If the result is a tolerance tau, it is corrected as follows.
//
// A pair of runs of the whole duration, without a trajectory, has the tolerances 16 tau and tau. If
// 16 tau exceeds 2e-5 m or the limit that contact sets, the runs have this bound and a 16th of it
// instead. The table predicts a distance between the runs. The ratio of the real distance to the
// predicted one estimates by which factor this scene's errors exceed the table's. The corrected
// tolerance allows for this factor, on the assumption that it is the same at all tolerances.
//
// Any run may fail, for example by gaining energy (energy_watch.h). If a run of the pair fails, the
// pair is repeated with both tolerances divided by 16, twice at most. If the corrected tolerance is
// looser than both tolerances of the pair, a run with it is tried as well. If that run fails, the
// tolerance is divided by 4, until a run succeeds or the tolerance is that of the looser run.
//
// The two runs may differ by more than a tenth of a body's motion or size. From then on their
// distance no longer grows with the tolerance. If the accuracy then needs a tighter tolerance than
// both runs have, the motion is reported as chaotic and the accuracy as out of reach. The table's
// tolerance then replaces the corrected tolerance.
//
// If the case names no method and has neither contact nor a strain limit, `verlet` may replace the
// choice. A whole run of verlet, with nine tenths of the longest stable step, must take less work
// than the looser of the two runs. Two verlet runs, with this step and half of it, must confirm the
// accuracy. Work is counted, not timed, so the choice is the same on every machine.
//
// The result is written to Case::time, Case::accuracy_choice and Case::resolved_text. The table's
// tolerance is kept if the pilot finds no error or if no pair of runs succeeds; accuracy_choice
// then says so. Cost: usually up to three times that of the run, limited by compute.cpu_limit.
// Throws CaseError like choose_accuracy() and build_scene().
PilotReport correct_accuracy(Case& target, const PilotOptions& options = {});

}  // namespace weft::sim
