// Settles time.accuracy by pilot runs.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "sim/base/bill.h"
#include "sim/case/case.h"

namespace weft::sim {

struct PilotOptions {
  // `notice` is called before each stage of the pilot with a description. `progress` is called with
  // the simulated time that the stage has reached (s, from 0 to the duration). Both may be empty.
  std::function<void(const std::string& text)> notice;
  std::function<void(double time)> progress;
  // A nonzero value stops the pilot after the current step. A signal handler may set it. May be
  // null.
  const std::atomic<int>* stop_signal = nullptr;
};

struct PilotReport {
  Cost cost;
  // `interrupted` is set if the stop signal ended the pilot, `limit_reason` if compute.cpu_limit
  // did. The case is then unchanged and must not be run.
  bool interrupted = false;
  std::string limit_reason;
  bool ended_run() const { return interrupted || !limit_reason.empty(); }
};

// Settles `time.accuracy`. First chooses by the table (choose_accuracy()). If that sets a tolerance
// tau, corrects it as follows.
//
// Two runs of the whole duration, without a trajectory, have the tolerances 16 tau and tau. If 16
// tau exceeds 2e-5 m or the limit that contact sets, the runs have this bound and a 16th of it
// instead. The ratio of the distance between the runs to the distance that the table predicts tells
// by which factor this scene's errors exceed the table's. The corrected tolerance allows for this
// factor, on the assumption that it is the same at all tolerances.
//
// The energy watch (energy_watch.h) checks every run. If the corrected tolerance is looser than the
// tolerances of both runs, a run with it is checked as well. If a run of the pair fails, both
// tolerances are replaced by a 16th. If the run with the corrected tolerance fails, a quarter of
// that tolerance is tried.
//
// The two runs may differ by more than a tenth of a body's motion or size. From then on their
// distance no longer grows with the tolerance. If the accuracy then needs a tighter tolerance than
// both runs have, the motion is reported as chaotic and the accuracy as out of reach. The table's
// tolerance stays.
//
// If the case names no method and has no contact, `verlet` may replace the choice. A whole run of
// verlet, with nine tenths of the longest stable step, must take less work than the looser of the
// two runs. Two verlet runs, with this step and half of it, must confirm the accuracy. Work is
// counted, not timed, so the choice is the same on every machine.
//
// The result is written to Case::accuracy_choice and Case::resolved_text. The tolerance stays if
// the pilot finds no error or if no run succeeds; the text then says so. Cost: up to three times
// that of the run, limited by compute.cpu_limit. Throws CaseError like choose_accuracy() and
// build_scene().
PilotReport correct_accuracy(Case& target, const PilotOptions& options = {});

}  // namespace weft::sim
