// The stability test: a grid of unusual cases, each of which must finish correctly or report
// clearly why it does not.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bench/stability_cell.h"
#include "bench/stability_grid.h"
#include "bench/stability_verdict.h"
#include "sim/case/case_text.h"
#include "sim/view/heat_map.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

using sim::number_text;

// Limits of CPU time in medians. They are below `most_medians`, so that a run that does not finish
// ends before it counts as too slow.
constexpr double first_limit_in_medians = 30, limit_in_medians = 45;
static_assert(limit_in_medians < most_medians);
constexpr double generous_limit = 60;  // s
// Tolerances of the converged runs, m: a hundredth or a tenth of those of most cells.
constexpr double reference_tolerance = 1e-7, quick_reference_tolerance = 1e-6;

struct Run {
  Slice slice;
  std::vector<CellResult> results;  // by cell
};

using Counts = std::array<int, outcome_count>;

Counts count(const Run& run, const std::string& method) {
  Counts counts{};
  for (std::size_t i = 0; i < run.results.size(); ++i) {
    if (method.empty() || run.slice.cells[i].method == method)
      ++counts[static_cast<std::size_t>(run.results[i].outcome)];
  }
  return counts;
}

std::string x_label(const Slice& slice, const Cell& cell) {
  return slice.x_labels[static_cast<std::size_t>(cell.x)];
}
std::string y_label(const Slice& slice, const Cell& cell) {
  return slice.y_title.empty() ? "" : slice.y_labels[static_cast<std::size_t>(cell.y)];
}

void tell(const Cell& cell, const CellResult& result) {
  std::fprintf(stderr, "%-10s %8.3f s  %s%s%s\n", outcome_name(result.outcome), result.cpu,
               cell.command().c_str(), result.message.empty() ? "" : "  # ",
               result.message.c_str());
}

// Returns the median cost of the cells that ended by themselves, in s of CPU for 81 vertices.
double median_cost(const std::vector<Run>& runs) {
  std::vector<double> costs;
  for (const Run& run : runs) {
    for (std::size_t i = 0; i < run.results.size(); ++i) {
      const Outcome outcome = run.results[i].outcome;
      if (outcome <= Outcome::inexact || outcome == Outcome::failed)
        costs.push_back(run.results[i].cpu / run.slice.cells[i].size);
    }
  }
  return costs.empty() ? 0 : median(costs);
}

// Returns the simulated times: "0.1", or "0.001..0.1" if they differ.
std::string times_text(const Run& run, const std::string& method) {
  SimulatedTimes times;
  for (const Cell& cell : run.slice.cells)
    if (cell.method == method) times.add(cell);
  char shortest[32], longest[32];
  std::snprintf(shortest, sizeof shortest, "%.3g..", times.shortest);
  std::snprintf(longest, sizeof longest, "%.3g", times.longest);
  return times.shortest == times.longest ? longest : std::string(shortest) + longest;
}

void print_counts(const std::string& slice, const std::string& method, const std::string& times,
                  const Counts& counts) {
  std::printf("%-24s %-18s %-14s", slice.c_str(), method.c_str(), times.c_str());
  for (const int each : counts)
    std::printf(" %10s", each == 0 ? "." : std::to_string(each).c_str());
  std::printf("\n");
}

// Marks cells as too slow, however they ended, if they cost more than `most_medians` medians. If
// the limit was measured on a slower machine, more is allowed.
void find_slow(std::vector<Run>& runs, double limit) {
  const double most = most_medians * std::max(median_cost(runs), limit / limit_in_medians);
  for (Run& run : runs) {
    for (std::size_t i = 0; i < run.results.size(); ++i) {
      CellResult& result = run.results[i];
      if (result.outcome > Outcome::limited || result.cpu <= most * run.slice.cells[i].size)
        continue;
      result.message = std::string(outcome_name(result.outcome)) + " after " +
                       number_text(result.cpu) + " s, " + result.message;
      result.outcome = Outcome::too_slow;
    }
  }
}

void print_table(const std::vector<Run>& runs, double limit) {
  std::printf("%-24s %-18s %-14s", "slice", "method", "simulated, s");
  for (int i = 0; i < outcome_count; ++i)
    std::printf(" %10s", outcome_name(static_cast<Outcome>(i)));
  std::printf("\n");
  Counts all{};
  for (const Run& run : runs) {
    for (const std::string& method : run.slice.methods) {
      const Counts counts = count(run, method);
      print_counts(run.slice.name, method, times_text(run, method), counts);
      for (std::size_t i = 0; i < counts.size(); ++i) all[i] += counts[i];
    }
  }
  print_counts("all", "", "", all);
  const double median = median_cost(runs);
  std::printf(
      "median cost %.2g s of CPU time; a cell of 81 vertices is limited to %.3g s, %.0f times as "
      "much\n",
      median, limit, median > 0 ? limit / median : 0);
}

SimulatedTimes simulated_times(const std::vector<Run>& runs) {
  SimulatedTimes times;
  for (const Run& run : runs)
    for (const Cell& cell : run.slice.cells) times.add(cell);
  return times;
}

Shares shares_of(const std::vector<Run>& runs) {
  Shares shares;
  for (const Run& run : runs)
    for (std::size_t i = 0; i < run.results.size(); ++i)
      shares.add(run.slice.cells[i], run.results[i]);
  return shares;
}

void print_verdict(const std::vector<Run>& runs, double wall) {
  const SimulatedTimes times = simulated_times(runs);
  std::printf("simulated %.3g to %.3g s; %d of %d cells for 1 s and more\n", times.shortest,
              times.longest, times.long_cells, times.cells);
  const Shares shares = shares_of(runs);
  const double percent = 100.0 / std::max(1, shares.cells);
  const auto print = [&](const char* what, int count, double most) {
    std::printf("  %s %d, %.1f %% (at most %.0f %%)\n", what, count, percent * count, 100 * most);
  };
  std::printf("of %d cells in which obstacles and pins are at rest (%s):\n", shares.cells,
              shares.are_small() ? "passed" : "not passed");
  print("failed", shares.failed, Shares::most_failed);
  print("limited", shares.limited, Shares::most_limited);
  print("inexact, with a tolerance", shares.inexact, Shares::most_inexact);
  std::size_t with_reference = 0;
  for (const Run& run : runs)
    for (const CellResult& result : run.results) with_reference += std::isnan(result.error) ? 0 : 1;
  std::printf("%zu ends were compared with a converged run; %.0f s by the clock\n", with_reference,
              wall);
}

void print_unfinished(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    for (std::size_t i = 0; i < run.results.size(); ++i) {
      const CellResult& result = run.results[i];
      const bool strayed = result.outcome == Outcome::inexact && run.slice.cells[i].tolerance > 0;
      if (result.outcome < Outcome::limited && !strayed) continue;
      std::printf("%s: %s\n  %s\n", outcome_name(result.outcome), result.message.c_str(),
                  run.slice.cells[i].command().c_str());
    }
  }
}

nlohmann::ordered_json json_of(const std::vector<Run>& runs, double limit) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Run& run : runs) {
    for (std::size_t i = 0; i < run.results.size(); ++i) {
      const Cell& cell = run.slice.cells[i];
      const CellResult& result = run.results[i];
      rows.push_back({{"slice", cell.slice},
                      {"method", cell.method},
                      {"x", x_label(run.slice, cell)},
                      {"y", y_label(run.slice, cell)},
                      {"outcome", outcome_name(result.outcome)},
                      {"forbidden", is_forbidden(result.outcome)},
                      {"message", result.message},
                      {"cpu_s", result.cpu},
                      {"duration_s", cell.duration},
                      {"reached_s", result.reached},
                      {"steps", result.steps},
                      {"energy_share", result.energy},
                      {"energy_lost", result.lost},
                      {"error_m", result.error},
                      {"command", cell.command()}});
    }
  }
  const Shares shares = shares_of(runs);
  return {{"limit_s", limit},
          {"median_cpu_s", median_cost(runs)},
          {"cells_at_rest", shares.cells},
          {"failed_at_rest", shares.failed},
          {"limited_at_rest", shares.limited},
          {"inexact_at_rest", shares.inexact},
          {"rows", std::move(rows)}};
}

std::string in_csv(std::string text) {
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2)
    text.insert(at, 1, '"');
  return '"' + text + '"';
}

std::string csv_of(const std::vector<Run>& runs) {
  std::ostringstream out;
  out << "slice,method,x,y,outcome,cpu_s,duration_s,reached_s,steps,energy_share,energy_lost,"
         "error_m,message,command\n";
  for (const Run& run : runs) {
    for (std::size_t i = 0; i < run.results.size(); ++i) {
      const Cell& cell = run.slice.cells[i];
      const CellResult& result = run.results[i];
      char cost[32], share[32], lost[32] = "", error[32] = "";
      std::snprintf(cost, sizeof cost, "%.3f", result.cpu);
      std::snprintf(share, sizeof share, "%.3g", result.energy);
      if (!std::isnan(result.lost)) std::snprintf(lost, sizeof lost, "%.3g", result.lost);
      if (!std::isnan(result.error)) std::snprintf(error, sizeof error, "%.3g", result.error);
      out << cell.slice << ',' << cell.method << ',' << x_label(run.slice, cell) << ','
          << y_label(run.slice, cell) << ',' << outcome_name(result.outcome) << ',' << cost << ','
          << number_text(cell.duration) << ',' << number_text(result.reached) << ',' << result.steps
          << ',' << share << ',' << lost << ',' << error << ',' << in_csv(result.message) << ','
          << in_csv(cell.command()) << '\n';
    }
  }
  return out.str();
}

// Returns the class in the picture: finished, inexact, refused, failed, limited, or forbidden.
int class_of(Outcome outcome) {
  return std::min(static_cast<int>(outcome), static_cast<int>(Outcome::too_slow));
}

sim::HeatPanel panel_of(const Run& run, const std::string& method) {
  sim::HeatPanel panel;
  panel.x_labels = run.slice.x_labels;
  for (std::size_t i = 0; i < run.results.size(); ++i) {
    if (method.empty() || run.slice.cells[i].method == method)
      panel.cells.push_back(class_of(run.results[i].outcome));
  }
  return panel;
}

// Draws the picture. Sweeps stand side by side, with the methods as their rows. Every other slice
// has a row of the picture with one panel per method.
void draw(const std::vector<Run>& runs, const std::filesystem::path& path) {
  constexpr std::size_t sweeps_in_a_row = 4;
  sim::HeatMap map;
  map.title = "Stability: what becomes of a run";
  map.classes = {{"finished, checked", "#009e73"},
                 {"inexact at its end", "#8fd3b6"},
                 {"refused at the start", "#9fc9e8"},
                 {"failed, and said why", "#0072b2"},
                 {"ended at its limit", "#f0e442"},
                 {"wrong, not finite, too slow, hung or unclear", "#d55e00"}};
  int cells = 0;
  for (const Run& run : runs) {
    cells += static_cast<int>(run.results.size());
    if (run.slice.y_title.empty()) {
      if (map.rows.empty() || map.rows.back().panels.size() == sweeps_in_a_row)
        map.rows.push_back({});
      sim::HeatPanel panel = panel_of(run, "");
      panel.title = run.slice.name;
      panel.x_title = run.slice.x_title;
      panel.y_labels = run.slice.y_labels;
      map.rows.back().panels.push_back(std::move(panel));
      continue;
    }
    sim::HeatRow row{run.slice.name + " (across: " + run.slice.x_title + ")", {}};
    for (const std::string& method : run.slice.methods) {
      sim::HeatPanel panel = panel_of(run, method);
      panel.title = method;
      if (row.panels.empty()) {
        panel.y_title = run.slice.y_title;
        panel.y_labels = run.slice.y_labels;
      }
      row.panels.push_back(std::move(panel));
    }
    map.rows.push_back(std::move(row));
  }
  map.note = std::to_string(cells) + " runs; weft bench stability";
  sim::write_svg(map, path);
}

// Returns the limit (s) for a run of 81 vertices on this machine, measured on the small grid.
double usual_limit(int jobs) {
  std::vector<Run> runs;
  for (const Slice& slice : make_slices({}, true))
    runs.push_back({slice, run_cells(slice.cells, {}, generous_limit, jobs, [](auto&, auto&) {})});
  return first_limit_in_medians * median_cost(runs);
}

double limit_of(const StabilityOptions& options) {
  if (options.limit) return *options.limit;
  return options.quick ? generous_limit : usual_limit(options.jobs);
}

// Runs the cells that ended at their limit again, with a limit that follows from the median of all:
// the machine may have been faster when the limit was measured on the small grid. Returns the limit
// (s).
double run_limited_again(std::vector<Run>& runs, const ConvergedEnds& converged, double limit,
                         int jobs) {
  const double usual = limit_in_medians * median_cost(runs);
  if (usual <= limit) return limit;
  limit = usual;
  for (Run& run : runs) {
    std::vector<Cell> cells;
    std::vector<CellResult*> results;
    for (std::size_t i = 0; i < run.results.size(); ++i) {
      if (run.results[i].outcome != Outcome::limited) continue;
      cells.push_back(run.slice.cells[i]);
      results.push_back(&run.results[i]);
    }
    const std::vector<CellResult> again = run_cells(cells, converged, limit, jobs, tell);
    for (std::size_t i = 0; i < again.size(); ++i) *results[i] = again[i];
  }
  return limit;
}

// Judges shares only on the whole grid or the small one. In a single slice most cells may have to
// fail, and a sample has too few cells.
bool is_passed(const std::vector<Run>& runs, const StabilityOptions& options) {
  for (const Run& run : runs)
    for (const CellResult& result : run.results)
      if (is_forbidden(result.outcome)) return false;
  const bool is_part = !options.slices.empty() || options.every > 1;
  return is_part || shares_of(runs).are_small();
}

}  // namespace

int run_stability(const StabilityOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  double limit = limit_of(options);
  std::vector<Run> runs;
  const auto keep = [&] {
    if (!options.csv.empty()) sim::write_text(csv_of(runs), options.csv);
    if (!options.plot.empty()) draw(runs, options.plot);
  };
  const std::vector<Slice> slices =
      every_nth(make_slices(options.slices, options.quick), options.every);
  const double tolerance = options.quick ? quick_reference_tolerance : reference_tolerance;
  ConvergedEnds converged;
  for (const Slice& slice : slices) converged.find(slice.cells, tolerance, limit, options.jobs);
  for (const Slice& slice : slices) {
    runs.push_back({slice, run_cells(slice.cells, converged, limit, options.jobs, tell)});
    keep();  // keeps the results if a later run is interrupted
  }
  if (!options.limit) {
    limit = run_limited_again(runs, converged, limit, options.jobs);
    find_slow(runs, limit);
  }
  keep();
  if (options.json) {
    std::printf("%s\n", json_of(runs, limit).dump(2).c_str());
  } else {
    print_table(runs, limit);
    print_verdict(runs,
                  std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    print_unfinished(runs);
  }
  return is_passed(runs, options) ? 0 : 1;
}

}  // namespace weft::bench
