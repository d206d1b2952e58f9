// The plan of a sweep: the list of its runs, frozen when it is made.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/sweep/sweep_case.h"

namespace weft::sim {

struct PlannedRun {
  std::string hash;                 // run_identity.h; names the folder of the run
  std::vector<std::string> values;  // TOML, one per factor of the plan
  // Reason why the case of this combination is refused, with its place; empty for a case that can
  // run. Such a run has failed from the start.
  std::string refusal;
  std::vector<std::string> inputs;  // paths of the files it reads: input_paths() (run_identity.h)
  std::string case_text;  // portable_case_text() (run_identity.h); empty for a refused run
  // Measure of the run's cost, by which long runs are found: vertices of all bodies times simulated
  // seconds. Shapes from files count as one vertex.
  double work = 0;
};

struct SweepPlan {
  std::string sweep;                 // path of the sweep file
  std::vector<std::string> factors;  // case keys that vary: factors, then the key of repeats
  LimitsCase limits;
  bool estimate_error = false;  // runs measure their errors (weft run --estimate-error)
  // [outputs] of the case and of the sweep file (sweep_outputs.h).
  std::vector<OutputExpression> case_outputs, sweep_outputs;
  // SHA-256 of the files that the runs read, by path (RunHasher::digests(), run_identity.h).
  std::map<std::string, std::string> digests;
  std::vector<PlannedRun> runs;
  int left_out = 0;  // number of combinations that rules leave out
};

// Plans the runs of a sweep. `overrides` are texts "KEY=VALUE" for all runs, applied after [set].
// Two calls with the same files give the same plan, on any machine.
//
// Throws CaseError for a key or value of the sweep that its case refuses by itself, with its place
// in the sweep file, for a rule that leaves nothing, and for a sweep of which all runs are refused.
// A combination that is refused while others are not becomes a run with a refusal. Costs about a
// millisecond per run (bench/results/, sweeps.txt).
SweepPlan plan_sweep(const SweepCase& sweep, const std::vector<std::string>& overrides = {});

// Returns the paths of the sweep file, of its case and of the files that this includes. The files
// that runs read are in SweepPlan::digests. Throws CaseError as plan_sweep() does for keys and
// values.
std::vector<std::string> files_of_sweep(const SweepCase& sweep,
                                        const std::vector<std::string>& overrides = {});

}  // namespace weft::sim
