// The list of runs that a sweep has still to do, frozen so that all its workers mean the same one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/sweep/sweep_plan.h"

namespace weft::sim {

struct RunToDo {
  std::size_t index = 0;  // of the run in the plan
  // RunFolder::result_mark() of the failure that is to be computed again; empty for a run that had
  // no result. A run that gets another result meanwhile needs no worker any more.
  std::string failed_result = {};
};

// Returns the runs of a plan that can run and have no result or, if `rerun_failed`, have failed.
// Runs with equal hashes appear once. Interrupted runs come first, then those with the most work
// (PlannedRun::work), then those that come first in the plan. Costs about 30 microseconds per run.
std::vector<RunToDo> runs_to_do(const std::filesystem::path& directory, const SweepPlan& plan,
                                bool rerun_failed);

// Returns the path of the list that planning writes: DIRECTORY/to_do.json.
std::filesystem::path to_do_path(const std::filesystem::path& directory);

// Writes a list. A former one is replaced as a whole. Throws FileError.
void write_to_do_list(const std::filesystem::path& path, const SweepPlan& plan,
                      const std::vector<RunToDo>& list);
// Reads a list for a plan. Throws FileError if it cannot be read, or has a run that the plan lacks.
std::vector<RunToDo> read_to_do_list(const std::filesystem::path& path, const SweepPlan& plan);

// A worker's part of a list.
struct Slice {
  std::vector<RunToDo> own, others;
};
// Returns slice `number` of `count`: entries number, number + count, ... of the list are its own.
// Precondition: number < count.
Slice slice_of(const std::vector<RunToDo>& list, std::size_t number, std::size_t count);

}  // namespace weft::sim
