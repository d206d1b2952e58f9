// What an accuracy asks of a scene, corrected by pilot runs of it.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "sim/bill.h"
#include "sim/case/case.h"

namespace weft::sim {

struct PilotOptions {
  // Told before each stage of the pilot what it does, and within it how far it came (s of the
  // simulated time, from 0 to the duration). May be empty.
  std::function<void(const std::string& text)> notice;
  std::function<void(double time)> progress;
  // Set from outside (a signal) to stop after the current step. May be null.
  const std::atomic<int>* stop_signal = nullptr;
};

struct PilotReport {
  Cost cost;
  // Stopped from outside, or by compute.cpu_limit with its reason: the case is as it was, and there
  // is no run to be made of it.
  bool interrupted = false;
  std::string limit_reason;
  bool ended_run() const { return interrupted || !limit_reason.empty(); }
};

// Where `time.accuracy` has chosen a tolerance tau by the table: two runs of the whole duration,
// without a trajectory, at 16 tau (no more than 2e-5 m and what contact allows) and a 16th of that.
// Their distance over that of the table is the factor by which this scene's errors are larger than
// the table's, at other tolerances too: it is taken out of the tolerance.
//
// Every run is held against the energy watch (energy_watch.h), and so is one at the tolerance found
// if that is looser than both: a tolerance with which the motion gains energy, or that fails
// otherwise, is left for a 16th of it or, at the end, a quarter. Where the two runs come further
// apart than a tenth of a body's motion or size, their distance no longer grows with the tolerance:
// an accuracy that needs a tighter one than both is said to be out of reach, the motion being
// chaotic, and the table's tolerance stays.
//
// Where the method is free, too, and there is no contact, `verlet` takes its place if all of its
// steps, nine tenths of the longest stable one, are less work than the looser of those runs, and
// two runs of it, at that share and at half of it, find it as accurate as asked for. Work is
// counted, not timed: the choice is the same everywhere.
//
// What was found is added to Case::accuracy_choice and Case::resolved_text. Leaves the case alone
// where there is nothing to correct, and says so where no run succeeds. Costs up to three times
// what the run will; compute.cpu_limit limits it. Throws CaseError as build_scene() does.
PilotReport correct_accuracy(Case& target, const PilotOptions& options = {});

}  // namespace weft::sim
