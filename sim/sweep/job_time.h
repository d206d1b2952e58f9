// The time that a batch system leaves to its job.
#pragma once

#include <optional>

namespace weft::sim {

// Returns the time (s) until Slurm ends the job that this process belongs to, or nothing outside a
// job of Slurm, or if Slurm does not tell. Reads SLURM_JOB_END_TIME or, where a version of Slurm
// does not set it, asks squeue once.
std::optional<double> seconds_left_of_job();

}  // namespace weft::sim
