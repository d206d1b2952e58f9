// Weft's shells against those of CalculiX: whole commands, each on one thread.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/check_row.h"

namespace weft::bench {

// Runs both programs on shells of several sizes and calls `done` for each row: the error and cost
// of each run, and the ratio of their costs at equal errors. Without CalculiX there is one row,
// which says so.
void compare_with_calculix(const std::function<void(const CheckRow&)>& done);

// Returns the names of these rows.
std::vector<std::string> comparison_names();

// Writes shells_calculix.svg, error against CPU time, from these rows.
void write_comparison(const std::vector<CheckRow>& rows, const std::filesystem::path& directory);

}  // namespace weft::bench
