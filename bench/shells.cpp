// Shells and cloth against closed forms and published figures: value, error and CPU time by
// resolution.
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/calculix_comparison.h"
#include "bench/check_row.h"
#include "bench/cloth_checks.h"
#include "bench/experiments.h"
#include "bench/mode_checks.h"
#include "bench/shell_checks.h"
#include "bench/shell_solver_rows.h"
#include "bench/snap_through.h"

namespace weft::bench {

namespace {

// Names the comparison with CalculiX among the cases.
constexpr const char* calculix = "calculix";

// Checks that one chart shows.
struct Group {
  std::string chart;
  std::vector<CaseCheck> checks;
};
std::vector<Group> groups() {
  return {{"strips", strip_checks()},
          {"shells", shell_checks()},
          {"snap_through", snap_through_checks()},
          {"modes", mode_checks()},
          {"bending", cloth_checks()}};
}

bool is_asked(const ShellsOptions& options, const std::string& name) {
  return options.cases.empty() || std::ranges::find(options.cases, name) != options.cases.end();
}

void print_json(const std::vector<CheckRow>& rows) {
  nlohmann::json all = nlohmann::json::array();
  for (const CheckRow& row : rows) all.push_back(json_of(row));
  std::printf("%s\n", nlohmann::json{{"rows", all}}.dump(2).c_str());
}

}  // namespace

std::vector<std::string> shell_check_names() {
  std::vector<std::string> names;
  for (const Group& group : groups()) {
    for (const CaseCheck& each : group.checks) {
      if (std::ranges::find(names, each.case_name) == names.end()) names.push_back(each.case_name);
    }
  }
  names.emplace_back(shell_solver);
  names.emplace_back(calculix);
  return names;
}

int run_shells(const ShellsOptions& options) {
  if (!options.json) print_heading("check");
  std::vector<CheckRow> rows, compared;
  const auto show = [&](const CheckRow& row) {
    if (options.json) return;
    print_row(row);
    std::fflush(stdout);
  };
  for (const Group& group : groups()) {
    for (const CaseCheck& check : group.checks) {
      if (!is_asked(options, check.case_name)) continue;
      for (const CheckedImage& image : check.images) {
        rows.push_back(run_check(check, image));
        rows.back().chart = group.chart;
        show(rows.back());
      }
    }
  }
  if (is_asked(options, shell_solver)) {
    for (const CheckRow& row : shell_solver_rows(show)) rows.push_back(row);
  }
  if (is_asked(options, calculix)) {
    if (!options.json) {
      std::printf("\n");
      print_heading("beside CalculiX");
    }
    compare_with_calculix([&](const CheckRow& row) {
      compared.push_back(row);
      show(row);
    });
  }
  if (!options.plots.empty()) {
    write_convergence(rows, options.plots);
    write_comparison(compared, options.plots);
  }
  rows.insert(rows.end(), compared.begin(), compared.end());
  if (options.json) print_json(rows);
  return std::ranges::all_of(rows, &CheckRow::holds) ? 0 : 1;
}

}  // namespace weft::bench
