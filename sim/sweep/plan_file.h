// The file in which a sweep's folder keeps its plan.
#pragma once

#include <filesystem>

#include "sim/sweep/sweep_plan.h"

namespace weft::sim {

// Writes DIRECTORY/plan.json, and creates the folder. A former plan is replaced as a whole. Throws
// FileError.
void write_plan(const std::filesystem::path& directory, const SweepPlan& plan);

// Reads DIRECTORY/plan.json. Throws FileError if it cannot be read or is no plan.
SweepPlan read_plan(const std::filesystem::path& directory);

}  // namespace weft::sim
