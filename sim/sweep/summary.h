// The summary of a sweep: one row per run, with its factors and outputs.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace weft::sim {

// The value of a factor in a run.
struct FactorValue {
  std::string text;              // as tables show it
  std::optional<double> number;  // empty for a text; true is 1, false 0
};

// One run of a sweep.
struct SummaryRow {
  std::string hash;                  // name of its folder
  std::string status;                // "done", "failed", "interrupted", "not begun", ...
  std::string failure;               // kind of a failure; empty without one
  std::string reason;                // reason of a failure, in words; else empty
  std::vector<FactorValue> factors;  // in the order of Summary::factors
  std::vector<double> outputs;       // in the order of Summary::outputs; NaN for what is missing
  bool has_ended = false;            // if false, the members below mean nothing
  double wall_time = 0;              // s
  double cpu_time = 0;               // s
  double peak_memory = 0;            // MiB
  std::string version;               // of Weft
};

struct Summary {
  std::vector<std::string> factors;  // keys of the case that vary
  std::vector<std::string> outputs;  // names of outputs
  std::vector<SummaryRow> rows;      // in the order of the plan
};

// Names of the columns before and after those of factors and outputs; `run` is a number from 1.
constexpr std::array<std::string_view, 5> first_columns{"run", "hash", "status", "failure",
                                                        "reason"};
constexpr std::array<std::string_view, 4> last_columns{"wall_s", "cpu_s", "peak_memory_mib",
                                                       "weft_version"};

// Returns the summary as comma-separated values (RFC 4180, but with \n): a line of names, and a
// line per run. The columns are `first_columns`, the factors, the outputs and `last_columns`. A
// missing number is empty. Outputs read back as the same doubles.
std::string summary_csv(const Summary& summary);

// Writes `folder`/summary.csv and `folder`/summary.h5, each aside and renamed, so that a reader
// never sees a part of one. The same summary gives the same bytes. Throws FileError.
//
// summary.h5 has a dataset per column, with one entry per run: /hash, /status, /failure, /reason,
// /factors/KEY (float64, or strings if a value is a text), /outputs/NAME (float64, NaN if missing),
// /wall_s, /cpu_s, /peak_memory_mib (float64, NaN if the run has not ended) and /weft_version.
// Strings have a fixed length, in UTF-8. Attributes: format = "weft-summary", version = 1.
void write_summary(const Summary& summary, const std::filesystem::path& folder);

}  // namespace weft::sim
