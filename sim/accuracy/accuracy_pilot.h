// Settles time.accuracy by pilot runs.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "sim/base/bill.h"
#include "sim/case/case.h"

namespace weft::sim {

struct PilotOptions {
  // `notice` is called before each stage of the pilot, with a description. `progress` is called
  // with the simulated time that the stage has reached (s, from 0 to the duration). Both may be
  // empty.
  std::function<void(const std::string& text)> notice;
  std::function<void(double time)> progress;
  // Set from outside (by a signal) to stop after the current step. May be null.
  const std::atomic<int>* stop_signal = nullptr;
};

struct PilotReport {
  Cost cost;
  // Set if the pilot was stopped, from outside or, with `limit_reason`, by compute.cpu_limit. The
  // case is then unchanged and must not be run.
  bool interrupted = false;
  std::string limit_reason;
  bool ended_run() const { return interrupted || !limit_reason.empty(); }
};

// Settles `time.accuracy`: chooses by the table (choose_accuracy), then corrects a tolerance tau
// that it chose.
//
// Two runs of the whole duration, without a trajectory, use 16 tau (at most 2e-5 m and what contact
// allows) and a 16th of that. The ratio of their distance to the distance that the table predicts
// is the factor by which this scene's errors exceed the table's. The corrected tolerance allows for
// this factor, which is taken to hold at other tolerances too.
//
// The energy watch (energy_watch.h) checks every run. If the corrected tolerance is looser than
// both of these, a run with it is checked as well. A tolerance whose run gains energy, or fails
// otherwise, is replaced by a 16th of it, or for the corrected tolerance by a quarter.
//
// The two runs may come further apart than a tenth of a body's motion or size. From then on their
// distance no longer grows with the tolerance. If the accuracy needs a tighter tolerance than both
// runs have, the motion is reported as chaotic and the accuracy as out of reach; the table's
// tolerance stays.
//
// If the case leaves the method open and has no contact, `verlet` may replace the choice. Its whole
// run, with steps of nine tenths of the longest stable one, must take less work than the looser of
// the two runs. Two verlet runs, with these steps and with half of them, must confirm the accuracy.
// Work is counted, not timed, so the choice is the same on every machine.
//
// The result is appended to Case::accuracy_choice and Case::resolved_text. The case stays as it is
// if there is nothing to correct, and also if no run succeeds, which the text then says. Cost: up
// to three times that of the run, limited by compute.cpu_limit. Throws CaseError as
// choose_accuracy() and build_scene() do.
PilotReport correct_accuracy(Case& target, const PilotOptions& options = {});

}  // namespace weft::sim
