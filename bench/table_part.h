// Parts of the table of `weft bench shells`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/case_check.h"
#include "bench/check_row.h"

namespace weft::bench {

using RowSink = std::function<void(const CheckRow&)>;

// Checks that are run together.
struct TablePart {
  std::vector<std::string> checks;  // names of the rows
  std::string case_name;            // of cases/benchmarks/, without .toml, or a word for --cases
  std::string chart = {};           // of all rows; empty: none
  std::string heading = "check";    // of the table
  std::function<void(const RowSink&)> run;  // makes the rows, one by one
};

// Returns a part with a row for each image of the check.
TablePart part_of(const CaseCheck& check, const std::string& chart);

// Returns all parts in the order of the table.
std::vector<TablePart> table_parts();

// Returns true if the name of a check contains one of the texts, or if there are none.
bool is_wanted(const std::string& check, const std::vector<std::string>& only);

}  // namespace weft::bench
