// Shells and cloth against closed forms and published figures: value, error and CPU time by
// resolution.
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/calculix_comparison.h"
#include "bench/cloth_checks.h"
#include "bench/contact_rows.h"
#include "bench/experiments.h"
#include "bench/material_checks.h"
#include "bench/mode_checks.h"
#include "bench/shell_checks.h"
#include "bench/shell_solver_rows.h"
#include "bench/snap_through.h"
#include "bench/table_part.h"

namespace weft::bench {

namespace {

constexpr const char* beside_calculix = "beside CalculiX";

bool is_asked(const ShellsOptions& options, const TablePart& part) {
  const auto& cases = options.cases;
  return (cases.empty() || std::ranges::find(cases, part.case_name) != cases.end()) &&
         std::ranges::any_of(
             part.checks, [&](const std::string& check) { return is_wanted(check, options.only); });
}

// Prints rows as they come, with a heading where a table begins.
class RowPrinter {
 public:
  void print(const TablePart& part, const CheckRow& row) {
    if (heading_ != part.heading) {
      if (!heading_.empty()) std::printf("\n");
      print_heading(part.heading.c_str());
      heading_ = part.heading;
    }
    print_row(row);
    std::fflush(stdout);
  }

 private:
  std::string heading_;
};

void print_json(const std::vector<CheckRow>& rows) {
  nlohmann::json all = nlohmann::json::array();
  for (const CheckRow& row : rows) all.push_back(json_of(row));
  std::printf("%s\n", nlohmann::json{{"rows", all}}.dump(2).c_str());
}

}  // namespace

bool is_wanted(const std::string& check, const std::vector<std::string>& only) {
  return only.empty() || std::ranges::any_of(only, [&](const std::string& text) {
           return check.find(text) != std::string::npos;
         });
}

TablePart part_of(const CaseCheck& check, const std::string& chart) {
  return {.checks = {check.name},
          .case_name = check.case_name,
          .chart = chart,
          .run = [check](const RowSink& done) {
            for (const CheckedImage& image : check.images) done(run_check(check, image));
          }};
}

std::vector<TablePart> table_parts() {
  std::vector<TablePart> parts;
  const auto add = [&](const char* chart, const std::vector<CaseCheck>& checks) {
    for (const CaseCheck& check : checks) parts.push_back(part_of(check, chart));
  };
  add("strips", strip_checks());
  add("shells", shell_checks());
  add("snap_through", snap_through_checks());
  add("modes", mode_checks());
  add("bending", cloth_checks());
  parts.push_back(triangle_springs_part());
  add("lattices", lattice_checks());
  add("", material_checks());
  std::ranges::move(shell_drops(), std::back_inserter(parts));
  parts.push_back({.checks = {"multigrid iterations", "memory per vertex"},
                   .case_name = shell_solver,
                   .run = shell_solver_rows});
  parts.push_back({.checks = comparison_names(),
                   .case_name = "calculix",
                   .heading = beside_calculix,
                   .run = compare_with_calculix});
  return parts;
}

std::vector<std::string> shell_case_names() {
  std::vector<std::string> names;
  for (const TablePart& part : table_parts()) {
    if (std::ranges::find(names, part.case_name) == names.end()) names.push_back(part.case_name);
  }
  return names;
}

std::vector<std::string> shell_check_names() {
  std::vector<std::string> names;
  for (const TablePart& part : table_parts())
    names.insert(names.end(), part.checks.begin(), part.checks.end());
  return names;
}

int run_shells(const ShellsOptions& options) {
  RowPrinter printer;
  std::vector<CheckRow> rows, compared;
  for (const TablePart& part : table_parts()) {
    if (!is_asked(options, part)) continue;
    if (options.list) {
      for (const std::string& check : part.checks)
        if (is_wanted(check, options.only)) std::printf("%s\n", check.c_str());
      continue;
    }
    part.run([&](const CheckRow& row) {
      if (!is_wanted(row.check, options.only)) return;
      std::vector<CheckRow>& kept = part.heading == beside_calculix ? compared : rows;
      kept.push_back(row);
      kept.back().chart = part.chart;
      if (!options.json) printer.print(part, row);
    });
  }
  if (options.list) return 0;
  if (!options.plots.empty()) {
    write_convergence(rows, options.plots);
    write_comparison(compared, options.plots);
  }
  rows.insert(rows.end(), compared.begin(), compared.end());
  if (options.json) print_json(rows);
  return std::ranges::all_of(rows, &CheckRow::holds) ? 0 : 1;
}

}  // namespace weft::bench
