// Submits a planned sweep to Slurm, as one job array of slices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/sweep/sweep_plan.h"

namespace weft::sim {

struct SlurmOptions {
  std::string program;      // path of the weft command on the nodes
  std::string name;         // of the job
  int tasks = 0;            // slices; 0: one per run, at most as many as the array may have
  int tasks_at_a_time = 0;  // 0: no limit
  int cores = 1;            // per task, each of which computes a run at a time on each of them
  std::vector<std::string> sbatch_options;  // passed through, such as "--time=2:00:00"
};

struct SlurmJob {
  std::string id;
  int tasks = 0;
};

// Throws CaseError if a job of the last submission of this sweep has not ended.
void refuse_live_job(const std::filesystem::path& directory);

// Writes DIRECTORY/slurm/job.sh and submits it by sbatch. Task K of N computes the slice K/N
// (`weft sweep work`). A minute before its time is up, Slurm sends SIGTERM, upon which the runs
// write checkpoints; the next submission goes on with them. The number of the job is kept in
// DIRECTORY/slurm/job.json. Precondition: the plan is written, and some of its runs can run.
//
// Throws CaseError for more tasks than an array may have. Throws FileError if a file cannot be
// written, or sbatch is missing or refuses the script; its message has what sbatch said.
SlurmJob submit_to_slurm(const std::filesystem::path& directory, const SweepPlan& plan,
                         const SlurmOptions& options);

}  // namespace weft::sim
