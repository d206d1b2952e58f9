// Rows of the table of `weft bench shells`.
#pragma once

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace weft::bench {

// The demand on a row.
enum class Bound {
  none,    // nothing: the row only tells
  error,   // the error must not exceed `limit`
  wanted,  // the value should reach the reference; costs depend on the machine, so no row fails
};

struct CheckRow {
  std::string check = {};
  std::string chart = {};      // rows of one check with a chart are one of its lines; empty: none
  std::string case_path = {};  // of the source tree; empty: none
  std::vector<int> resolution = {};  // of the image, or elements along the sides
  int points = 0;                    // control points or vertices
  std::string quantity = {};         // the worst one, if several were measured
  double value = 0, reference = 0;
  double scale = 0;  // the error is |value - reference| / scale
  Bound bound = Bound::none;
  double limit = 0;  // of the error
  double cpu_s = 0;
  std::string source = {};   // of the reference
  std::string failure = {};  // why there is no value; empty: none
  bool skipped = false;      // `failure` says what the row would need

  double error() const { return std::abs(value - reference) / scale; }
  bool holds() const {
    if (skipped) return true;
    if (!failure.empty()) return false;
    return bound != Bound::error || error() <= limit;
  }
};

// {"check", "case", "resolution", "quantity", "value", "reference", "error", "limit", "cpu_s",
// "source"}; with "failure" or "skipped" in place of the numbers that are missing.
nlohmann::json json_of(const CheckRow& row);

// The heading of a table whose first column is called `what`.
void print_heading(const char* what);
void print_row(const CheckRow& row);

// Writes shells_CHART.svg for each chart of the rows: error against control points.
void write_convergence(const std::vector<CheckRow>& rows, const std::filesystem::path& directory);

}  // namespace weft::bench
