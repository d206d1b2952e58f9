// The files that a sweep writes into its folder, beside runs/.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/sweep/sweep_plan.h"

namespace weft::sim {

// Call it before the plan is written into `directory`. Throws CaseError if the sweep would
// overwrite one of `files` or a file that a run of the plan reads, even in the folder of an earlier
// sweep. Throws FileError if the folder has files of such names, but no plan of Weft: they belong
// to somebody else.
void refuse_lost_files(const std::filesystem::path& directory,
                       const std::vector<std::string>& files, const SweepPlan& plan);

}  // namespace weft::sim
