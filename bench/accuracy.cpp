// Run time against error: every method over a ladder of settings, against a converged reference.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bench/plot.h"
#include "bench/reference_run.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/error_estimate.h"

namespace weft::bench {

namespace {

using namespace sim;

// How a method is set for a given accuracy: by a tolerance (m) or by a step (s).
struct Ladder {
  const char* name;
  bool baseline;  // fixed steps, as others do
  bool implicit;
  bool by_step;
  double first;    // its coarsest setting
  double divisor;  // from one to the next
  int count;
  void (*apply)(TimeCase& time, double setting);
};

// Solved well below its own error, so that the method is judged and not its iterations.
void set_step(TimeCase& time, TimeMethod method, double step, int newton) {
  time.method = method;
  time.step = step;
  time.newton = newton;
  time.position_tolerance = 1e-3 * step;
  time.relative_tolerance = 1e-3;
}

constexpr Ladder ladders[] = {
    {"cvode", false, true, false, 1e-2, std::sqrt(10.0), 11,
     [](TimeCase& time, double setting) { set_tolerance(time, TimeMethod::cvode, setting); }},
    {"arkode", false, true, false, 1e-2, std::sqrt(10.0), 11,
     [](TimeCase& time, double setting) { set_tolerance(time, TimeMethod::arkode, setting); }},
    {"euler", false, true, false, 1e-2, std::sqrt(10.0), 7,
     [](TimeCase& time, double setting) { set_tolerance(time, TimeMethod::euler, setting); }},
    {"linear-euler", true, true, true, 1.0 / 30, 2, 9,
     [](TimeCase& time, double setting) { set_step(time, TimeMethod::euler, setting, 1); }},
    {"backward-euler", true, true, true, 1.0 / 30, 2, 9,
     [](TimeCase& time, double setting) { set_step(time, TimeMethod::euler, setting, 0); }},
    {"implicit-midpoint", true, true, true, 1.0 / 30, 2, 9,
     [](TimeCase& time, double setting) {
       set_step(time, TimeMethod::implicit_midpoint, setting, 0);
     }},
    // From half its longest stable step.
    {"verlet", true, false, false, 4e-5, 4, 5,
     [](TimeCase& time, double setting) { set_tolerance(time, TimeMethod::verlet, setting); }},
};

struct Row {
  const Ladder* ladder = nullptr;
  double setting = 0;
  double cpu = 0;               // s, median
  std::optional<double> error;  // m
  double energy_change = 0;  // J, of the total; without damping and moving pins it should be none
  IntegratorCounts counts;
  std::string failure;
  std::string setting_text() const {
    char text[40];
    std::snprintf(text, sizeof text, ladder->by_step ? "step %.3g s" : "tolerance %.2g m", setting);
    return text;
  }
};

struct Result {
  std::string name;
  Reference reference;
  std::vector<Row> rows;
};

Reference reference_of(const Case& source, const AccuracyOptions& options) {
  return find_reference(source, sample_times(options.horizon.value_or(source.time.duration), 20),
                        {.tolerance = options.reference_tolerance,
                         .certainty = options.certainty,
                         .budget = options.reference_budget});
}

Row measure(const Case& source, const Ladder& ladder, double setting, const Reference& reference,
            const AccuracyOptions& options) {
  Row row;
  row.ladder = &ladder;
  row.setting = setting;
  Case timed = source;
  ladder.apply(timed.time, setting);
  const double end[] = {reference.horizon};
  std::vector<double> cpu;
  for (int i = 0; i < options.repeats; ++i) {
    const TimedRun run = simulate(timed, end, options.budget);
    cpu.push_back(run.cpu);
    row.counts = run.counts;
    row.energy_change = run.last.total() - run.first.total();
    row.failure = run.failure;
    if (!run.failure.empty()) break;
    row.error = rms_distance(run.positions.back(), reference.positions.back());
    if (!std::isfinite(*row.error)) row.error.reset();
    if (!row.error) row.failure = "not finite";
  }
  row.cpu = median(cpu);
  return row;
}

// From coarse to fine, to where the error is lost in that of the reference or two settings in a row
// spend the budget: the coarsest ones may fail to come to an end where finer ones do.
void climb(const Case& source, const Ladder& ladder, const AccuracyOptions& options,
           Result& result) {
  double setting = ladder.first;
  int too_slow = 0;
  for (int i = 0; i < ladder.count; ++i, setting /= ladder.divisor) {
    const Row row = measure(source, ladder, setting, result.reference, options);
    std::fprintf(stderr, "%s, %s: %s\n", ladder.name, row.setting_text().c_str(),
                 row.error
                     ? (number_text(*row.error) + " m in " + number_text(row.cpu) + " s").c_str()
                     : row.failure.c_str());
    const bool lost = row.error && *row.error < 10 * result.reference.agreement;
    if (!lost) result.rows.push_back(row);
    too_slow = row.cpu > options.budget ? too_slow + 1 : 0;
    if (lost || too_slow == 2) break;
  }
}

// What a method takes for this error, between two rungs of its ladder on logarithmic scales;
// nothing where its ladder does not reach it.
std::optional<double> cost_at(const std::vector<Row>& rows, const char* method, double error) {
  std::optional<double> best;
  const Row* before = nullptr;
  for (const Row& row : rows) {
    if (row.ladder->name != method) continue;
    if (row.error && *row.error <= error) {
      double cost = row.cpu;
      if (before != nullptr && *before->error > error) {
        const double part =
            std::log(error / *before->error) / std::log(*row.error / *before->error);
        cost = before->cpu * std::pow(row.cpu / before->cpu, part);
      }
      if (!best || cost < *best) best = cost;
    }
    before = row.error ? &row : nullptr;
  }
  return best;
}

constexpr double shown_errors[] = {2e-2, 1e-2, 1e-3, 1e-4, 1e-5};

void print_table(const Result& result) {
  std::printf("\n%s: errors (RMS over particles) at t = %s s; the two references agree to %.1e m\n",
              result.name.c_str(), number_text(result.reference.horizon).c_str(),
              result.reference.agreement);
  std::printf("%-18s %-22s %10s %12s %8s %8s %9s %10s\n", "method", "setting", "CPU s", "error m",
              "steps", "newton", "linear", "energy J");
  for (const Row& row : result.rows) {
    if (!row.error) {
      std::printf("%-18s %-22s %10.4f %s\n", row.ladder->name, row.setting_text().c_str(), row.cpu,
                  row.failure.c_str());
      continue;
    }
    std::printf("%-18s %-22s %10.4f %12.3e %8lld %8lld %9lld %+10.1e\n", row.ladder->name,
                row.setting_text().c_str(), row.cpu, *row.error,
                static_cast<long long>(row.counts.steps),
                static_cast<long long>(row.counts.newton_iterations),
                static_cast<long long>(row.counts.linear_iterations), row.energy_change);
  }
}

// Weft's methods beside the cheapest implicit one of fixed steps.
void print_ratios(const Result& result) {
  std::printf("\nCPU s for an error of at most\n%-18s", "");
  for (const double error : shown_errors) std::printf(" %10.0e", error);
  std::optional<double> best[std::size(shown_errors)], fixed[std::size(shown_errors)];
  for (const Ladder& ladder : ladders) {
    std::printf("\n%-18s", ladder.name);
    for (std::size_t i = 0; i < std::size(shown_errors); ++i) {
      const auto cost = cost_at(result.rows, ladder.name, shown_errors[i]);
      if (cost)
        std::printf(" %10.4f", *cost);
      else
        std::printf(" %10s", "-");
      auto& slot = ladder.baseline ? fixed[i] : best[i];
      if (cost && (!ladder.baseline || ladder.implicit) && (!slot || *cost < *slot)) slot = cost;
    }
  }
  std::printf("\n%-18s", "fixed / weft");
  for (std::size_t i = 0; i < std::size(shown_errors); ++i) {
    if (best[i] && fixed[i])
      std::printf(" %9.1fx", *fixed[i] / *best[i]);
    else
      std::printf(" %10s", "-");
  }
  std::printf("\n");
}

nlohmann::ordered_json json_of(const Result& result) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Row& row : result.rows) {
    nlohmann::ordered_json entry{{"method", row.ladder->name},
                                 {"setting", row.setting_text()},
                                 {"cpu_s", row.cpu},
                                 {"error_m", nullptr},
                                 {"steps", row.counts.steps},
                                 {"energy_change_j", row.energy_change},
                                 {"newton", row.counts.newton_iterations},
                                 {"linear", row.counts.linear_iterations}};
    if (row.error) entry["error_m"] = *row.error;
    if (!row.failure.empty()) entry["failure"] = row.failure;
    rows.push_back(std::move(entry));
  }
  return {{"case", result.name},
          {"reference_agreement_m", result.reference.agreement},
          {"horizon_s", result.reference.horizon},
          {"rows", std::move(rows)}};
}

void plot(const Result& result, const std::filesystem::path& path) {
  Plot chart;
  chart.title = "Run time against error: " + result.name;
  chart.note = "at t = " + number_text(result.reference.horizon) + " s, one thread";
  chart.x.title = "error, m (RMS over particles)";
  chart.y.title = "CPU time, s";
  for (const Ladder& ladder : ladders) {
    Series series{ladder.name, {}, {}};
    for (const Row& row : result.rows) {
      if (row.ladder != &ladder || !row.error || *row.error <= 0) continue;
      series.x.push_back(*row.error);
      series.y.push_back(row.cpu);
    }
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  write_svg(chart, path);
}

// Where several cases share one --plot, each gets its own: NAME_CASE.svg.
std::filesystem::path plot_path(const AccuracyOptions& options, const std::string& name) {
  if (options.cases.size() == 1) return options.plot;
  std::filesystem::path path = options.plot;
  return path.replace_filename(path.stem().string() + "_" + name + path.extension().string());
}

bool is_wanted(const AccuracyOptions& options, const Ladder& ladder) {
  return options.methods.empty() || std::find(options.methods.begin(), options.methods.end(),
                                              ladder.name) != options.methods.end();
}

}  // namespace

std::vector<std::string> accuracy_methods() {
  std::vector<std::string> names;
  for (const Ladder& ladder : ladders) names.emplace_back(ladder.name);
  return names;
}

int run_accuracy(const AccuracyOptions& options) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  bool right = true;
  for (const std::string& path : options.cases) {
    // The case's own method and what belongs to it give way to the ladders.
    const Case source = read_case(path, options.overrides);
    Result result{std::filesystem::path(path).stem().string(), reference_of(source, options), {}};
    if (result.reference.positions.empty()) {
      std::fprintf(stderr, "%s: the references agree nowhere within %s m\n", path.c_str(),
                   number_text(options.certainty).c_str());
      right = false;
      continue;
    }
    for (const Ladder& ladder : ladders) {
      if (is_wanted(options, ladder)) climb(source, ladder, options, result);
    }
    if (options.json) {
      all.push_back(json_of(result));
    } else {
      print_table(result);
      print_ratios(result);
    }
    if (!options.plot.empty()) plot(result, plot_path(options, result.name));
  }
  if (options.json) std::printf("%s\n", (all.size() == 1 ? all[0] : all).dump(2).c_str());
  return right ? 0 : 1;
}

}  // namespace weft::bench
