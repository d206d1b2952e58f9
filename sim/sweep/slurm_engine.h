// Submits a planned sweep to Slurm, as one job array of slices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/sweep/sweep_plan.h"
#include "sim/sweep/to_do_list.h"

namespace weft::sim {

struct SlurmOptions {
  std::string program;         // path of the weft command on the nodes
  std::string name;            // of the job
  int tasks = 0;               // slices; 0: one per run, at most as many as the array may have
  int tasks_at_a_time = 0;     // 0: no limit
  int cores = 1;               // per task
  std::string worker_options;  // of `weft sweep work`, such as " --jobs 2"
  std::vector<std::string> sbatch_options;  // passed through, such as "--time=2:00:00"
};

struct SlurmJob {
  std::string id;
  int tasks = 0;
};

// Throws CaseError if a job of the last submission of this sweep has not ended.
void refuse_live_job(const std::filesystem::path& directory);

// Writes DIRECTORY/slurm/to_do.json, the frozen list, and DIRECTORY/slurm/job.sh, and submits the
// latter by sbatch. Task K of N computes the slice K/N of the list (`weft sweep work`). Tasks know
// when their job ends, and stop their runs at checkpoints before; where Slurm does not tell,
// SIGUSR1 gives notice. The next submission goes on. The number of the job is kept in
// DIRECTORY/slurm/job.json. Precondition: the plan is written, and the list is not empty.
//
// Throws CaseError for more tasks than an array may have. Throws FileError if a file cannot be
// written, or sbatch is missing or refuses the script; its message has what sbatch said.
SlurmJob submit_to_slurm(const std::filesystem::path& directory, const SweepPlan& plan,
                         const std::vector<RunToDo>& list, const SlurmOptions& options);

}  // namespace weft::sim
