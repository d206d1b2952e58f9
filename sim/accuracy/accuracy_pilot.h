// Settles time.accuracy by pilot runs.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "sim/base/bill.h"
#include "sim/case/case.h"

namespace weft::sim {

struct PilotOptions {
  // `notice` is told before each stage what the pilot does. `progress` is told how far the stage
  // has come (s of simulated time, from 0 to the duration). Both may be empty.
  std::function<void(const std::string& text)> notice;
  std::function<void(double time)> progress;
  // Set from outside (a signal) to stop after the current step. May be null.
  const std::atomic<int>* stop_signal = nullptr;
};

struct PilotReport {
  Cost cost;
  // Set if the pilot was stopped from outside, or by compute.cpu_limit with its reason. The case is
  // then as it was, and no run is to be made of it.
  bool interrupted = false;
  std::string limit_reason;
  bool ended_run() const { return interrupted || !limit_reason.empty(); }
};

// Settles `time.accuracy`: chooses by the table (choose_accuracy), then corrects a tolerance tau
// that it has chosen. Two runs of the whole duration, without a trajectory, use 16 tau (at most
// 2e-5 m and what contact allows) and a 16th of that. The ratio of their distance to the table's is
// the factor by which this scene's errors exceed the table's, at other tolerances too. The
// corrected tolerance allows for it.
//
// The energy watch (energy_watch.h) checks every run. If the corrected tolerance is looser than
// both, a run with it is checked as well. A tolerance with which the motion gains energy, or a run
// fails otherwise, is replaced by a 16th of it or, at the end, a quarter.
// The two runs may come further apart than a tenth of a body's motion or size: their distance then
// no longer grows with the tolerance. An accuracy that needs a tighter tolerance than both is
// reported as out of reach, the motion being chaotic, and the table's tolerance stays.
//
// If the method is free, too, and there is no contact, `verlet` may take its place. All of its
// steps, nine tenths of the longest stable one, must be less work than the looser of those runs.
// Two runs of it, at that share and at half of it, must find it as accurate as asked for. Work is
// counted, not timed: the choice is the same everywhere.
//
// The result is added to Case::accuracy_choice and Case::resolved_text. The case is left alone
// where there is nothing to correct, and the text says so where no run succeeds. Costs up to three
// times as much as the run; compute.cpu_limit limits it. Throws CaseError as
// choose_accuracy() and build_scene() do.
PilotReport correct_accuracy(Case& target, const PilotOptions& options = {});

}  // namespace weft::sim
