// The summary of a sweep: one row per run, with its factors and outputs.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace weft::sim {

// The value of a factor in a run.
using FactorValue = std::variant<double, bool, std::string>;

// One run of a sweep.
struct SummaryRow {
  std::string run;                   // name of its folder: the hash of the run
  std::vector<FactorValue> factors;  // in the order of Summary::factors
  std::vector<double> outputs;       // in the order of Summary::outputs; NaN for what is missing
  std::string status;                // "done", "failed", "interrupted" or "not begun"
  std::string reason;                // reason of a failure or a stop; else empty
  std::string version;               // version of Weft that made it; empty if it has not begun
  // s; NaN without a run
  double wall_time = std::numeric_limits<double>::quiet_NaN();
  double cpu_time = std::numeric_limits<double>::quiet_NaN();
};

struct Summary {
  std::vector<std::string> factors;  // keys of the case that vary
  std::vector<std::string> outputs;  // names of outputs
  std::vector<SummaryRow> rows;      // in the order of the plan
};

// Returns the summary as comma-separated values (RFC 4180, but with \n): a line of names, and a
// line per run. The columns are run, the factors, the outputs, status, reason, version, wall_s and
// cpu_s. A missing number is empty. Numbers read back as the same doubles.
std::string summary_csv(const Summary& summary);

// Writes `folder`/summary.csv and `folder`/summary.h5, each aside and renamed, so that a reader
// never sees a part of one. The same summary gives the same bytes. Throws FileError.
//
// summary.h5 has a dataset per column, with one entry per run: /run, /factors/KEY (float64, texts
// as strings, true as 1), /outputs/NAME (float64, NaN if missing), /status, /reason, /version,
// /wall_s and /cpu_s (float64, s). Strings have a fixed length, in UTF-8. Attributes: format =
// "weft-summary", version = 1.
void write_summary(const Summary& summary, const std::filesystem::path& folder);

}  // namespace weft::sim
