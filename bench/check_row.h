// Rows of the table of `weft bench shells`.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace weft::bench {

// The demand on a row.
enum class Bound {
  none,      // none, though there is a reference: coarse images show how errors fall
  error,     // the error must not exceed `limit`
  at_most,   // the value must not exceed the reference; the error is the excess
  wanted,    // the value should reach the reference; costs depend on the machine, so no row fails
  reported,  // none; there is no reference either
};

struct CheckRow {
  std::string check = {};
  std::string chart = {};      // rows of one check with a chart are one of its lines; empty: none
  std::string case_path = {};  // of the source tree; empty: none
  std::vector<int> resolution = {};  // of the image, or elements along the sides
  int points = 0;                    // control points or vertices
  std::string quantity = {};         // the worst one, if several were measured
  double value = 0, reference = 0;
  double scale = 0;  // of the error
  Bound bound = Bound::none;
  double limit = 0;  // of the error, by Bound::error
  double cpu_s = 0;
  std::string source = {};   // of the reference
  std::string failure = {};  // why there is no value; empty: none
  bool skipped = false;      // `failure` says what the row would need

  // True unless the row compares costs or has no reference.
  bool has_error() const { return bound != Bound::wanted && bound != Bound::reported; }
  // Precondition: has_error().
  double error() const {
    const double excess = value - reference;
    return (bound == Bound::at_most ? std::max(excess, 0.0) : std::abs(excess)) / scale;
  }
  bool holds() const {
    if (skipped) return true;
    if (!failure.empty()) return false;
    if (bound == Bound::at_most) return error() == 0;
    return bound != Bound::error || error() <= limit;
  }
};

// {"check", "case", "resolution", "quantity", "value", "reference", "error", "limit", "cpu_s",
// "source"}. Fields that do not apply are null. A row without a value has "failure" or "skipped",
// which say why.
nlohmann::json json_of(const CheckRow& row);

// The heading of a table whose first column is called `what`.
void print_heading(const char* what);
void print_row(const CheckRow& row);

// Writes shells_CHART.svg for each chart of the rows: error against control points.
void write_convergence(const std::vector<CheckRow>& rows, const std::filesystem::path& directory);

}  // namespace weft::bench
