// Run time against error: every method over a ladder of settings, against a converged reference.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "bench/cloth_peers.h"
#include "bench/cost_ratios.h"
#include "bench/experiments.h"
#include "bench/medians.h"
#include "bench/method_ladders.h"
#include "bench/reference_run.h"
#include "sim/accuracy/accuracy_choice.h"
#include "sim/accuracy/error_monitor.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

using namespace sim;

struct Row {
  std::string method, setting;
  double cpu = 0;               // s, median
  std::optional<double> error;  // m
  bool is_bound = false;        // `error` is an upper bound: the reference is not exact enough
  std::int64_t steps = 0;
  // Values that only Weft's own methods have.
  struct Own {
    double energy_change = 0;  // J, of the total; without damping and moving pins it should be none
    std::int64_t newton = 0, linear = 0;
  };
  std::optional<Own> own;
  std::string failure;
};

struct Result {
  std::string name;
  Reference reference;
  std::vector<Row> rows;
  std::vector<CostLadder> ladders;
};

void tell(const Row& row) {
  std::fprintf(stderr, "%s, %s: %s\n", row.method.c_str(), row.setting.c_str(),
               row.error
                   ? (number_text(*row.error) + " m in " + number_text(row.cpu) + " s").c_str()
                   : row.failure.c_str());
}

Reference reference_of(const Case& source, const AccuracyOptions& options) {
  return find_reference(source, sample_times(options.horizon.value_or(source.time.duration), 20),
                        {.tolerance = options.reference_tolerance,
                         .certainty = options.certainty,
                         .budget = options.reference_budget});
}

Row measure(const Case& source, const Ladder& ladder, double setting, const Reference& reference,
            const AccuracyOptions& options) {
  Row row;
  row.method = ladder.name;
  row.setting = setting_text(ladder, setting);
  Case timed = source;
  ladder.apply(timed.time, setting);
  const double end[] = {reference.horizon};
  std::vector<double> cpu;
  for (int i = 0; i < options.repeats; ++i) {
    const TimedRun run = simulate(timed, end, options.budget);
    cpu.push_back(run.cpu);
    row.steps = run.counts.steps;
    row.own = {run.energies.back().total() - run.energies.front().total(),
               run.counts.newton_iterations, run.counts.linear_iterations};
    row.failure = run.failure;
    if (!run.failure.empty()) break;
    row.error = rms_distance(run.positions.back(), reference.positions.back());
    if (!std::isfinite(*row.error)) row.error.reset();
    if (!row.error) row.failure = "not finite";
  }
  row.cpu = median(cpu);
  return row;
}

// Climbs a ladder from coarse to fine, to its end or until the error is too small for the
// reference. The table then states only an upper bound, ten times the reference's error. The rules
// are the same for Weft's methods and for those of other libraries.
template <class Measure>
void climb_rungs(const CostLadder& climbed, double setting, double divisor, int count,
                 const AccuracyOptions& options, const Measure& measure_at, Result& result) {
  CostLadder& ladder = result.ladders.emplace_back(climbed);
  LadderEnd end;
  for (int i = 0; i < count; ++i, setting /= divisor) {
    Row row = measure_at(setting);
    tell(row);
    const double smallest = 10 * result.reference.agreement;
    row.is_bound = row.error && *row.error < smallest;
    if (row.is_bound) row.error = smallest;
    ladder.points.push_back({row.cpu, row.error});
    result.rows.push_back(row);
    if (end.is_reached(row.cpu > options.budget) || row.is_bound) break;
  }
}

void climb(const Case& source, const Ladder& ladder, const AccuracyOptions& options,
           Result& result) {
  climb_rungs(
      {ladder.name, ladder.kind, false, {}}, ladder.first, ladder.divisor, ladder.count, options,
      [&](double setting) { return measure(source, ladder, setting, result.reference, options); },
      result);
}

Row measure_peer(const ClothMethod& method, const std::string& program, const ClothProblem& problem,
                 double step, const ClothVariant& variant, const Reference& reference,
                 const AccuracyOptions& options) {
  ClothSettings settings{.method = method.method,
                         .iterations = variant.iterations,
                         .tolerance = variant.tolerance,
                         .line_search = variant.line_search,
                         .budget = options.budget};
  settings.steps = std::lround(std::ceil(reference.horizon / step));
  settings.step = reference.horizon / static_cast<double>(settings.steps);
  Row row;
  row.method = method.name;
  row.setting = step_text(settings.step);
  if (*variant.label != 0) row.setting += std::string(", ") + variant.label;
  row.steps = settings.steps;
  std::vector<double> cpu;
  for (int i = 0; i < options.repeats; ++i) {
    const ClothOutcome outcome = run_cloth(program, problem, settings);
    cpu.push_back(outcome.cpu);
    row.failure = outcome.failure;
    if (!row.failure.empty()) break;
    std::vector<Vec3> position;
    for (const auto& p : outcome.position) position.emplace_back(p[0], p[1], p[2]);
    row.error = rms_distance(position, reference.positions.back());
  }
  row.cpu = median(cpu);
  return row;
}

// Climbs the steps of a library's method; each variant is a ladder of its own.
void climb(const Scene& scene, const ClothMethod& method, const AccuracyOptions& options,
           Result& result) {
  const auto program = cloth_program(method);
  const auto reason = beyond_peers(scene);
  if (!program || reason) {
    std::fprintf(stderr, "%s does not take part: %s\n", method.name,
                 reason ? reason->c_str() : "it was not found when Weft was built");
    return;
  }
  const ClothProblem problem = cloth_problem(scene);
  for (const ClothVariant& variant : method.variants) {
    climb_rungs(
        {method.name, StepKind::implicit, true, {}}, first_step, step_divisor, step_count, options,
        [&](double step) {
          return measure_peer(method, *program, problem, step, variant, result.reference, options);
        },
        result);
  }
}

// Returns a ladder for the chart: rows by growing cost, each more exact than all before.
std::vector<Row> best_of(std::vector<Row> rows) {
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.cpu < b.cpu; });
  std::vector<Row> best;
  for (Row& row : rows) {
    if (best.empty() || *row.error < *best.back().error) best.push_back(std::move(row));
  }
  return best;
}

constexpr int name_width = 18, ratio_width = 32;
constexpr double shown_errors[] = {2e-2, 1e-2, 1e-3, 1e-4, 1e-5};

void print_table(const Result& result) {
  std::printf("\n%s: errors (RMS over particles) at t = %s s; the two references agree to %.1e m\n",
              result.name.c_str(), number_text(result.reference.horizon).c_str(),
              result.reference.agreement);
  std::printf("%-*s %-34s %10s %12s %8s %8s %9s %10s\n", name_width, "method", "setting", "CPU s",
              "error m", "steps", "newton", "linear", "energy J");
  for (const Row& row : result.rows) {
    if (!row.error) {
      std::printf("%-*s %-34s %10.4f %s\n", name_width, row.method.c_str(), row.setting.c_str(),
                  row.cpu, row.failure.c_str());
      continue;
    }
    std::printf("%-*s %-34s %10.4f %2s%10.3e %8lld", name_width, row.method.c_str(),
                row.setting.c_str(), row.cpu, row.is_bound ? "<" : "", *row.error,
                static_cast<long long>(row.steps));
    if (row.own) {
      std::printf(" %8lld %9lld %+10.1e", static_cast<long long>(row.own->newton),
                  static_cast<long long>(row.own->linear), row.own->energy_change);
    }
    std::printf("\n");
  }
}

void print_numbers(const std::string& name, const char* format,
                   const std::array<std::optional<double>, std::size(shown_errors)>& numbers) {
  std::printf("\n%-*s", ratio_width, name.c_str());
  for (const auto& number : numbers) {
    char text[32] = "-";
    if (number) std::snprintf(text, sizeof text, format, *number);
    std::printf(" %10s", text);
  }
}

// Prints the cost of each method, and ratios: fixed steps, implicit or of any kind, over
// error-controlled ones and over Verlet's.
void print_ratios(const Result& result) {
  std::printf("\nCPU s for an error of at most\n%-*s", ratio_width, "");
  for (const double error : shown_errors) std::printf(" %10.0e", error);
  const auto print = [](const std::string& name, const char* format, const auto& number_at) {
    std::array<std::optional<double>, std::size(shown_errors)> numbers;
    std::transform(std::begin(shown_errors), std::end(shown_errors), numbers.begin(), number_at);
    print_numbers(name, format, numbers);
  };
  for (const std::string& method : accuracy_methods()) {
    const auto is_it = [&](const CostLadder& ladder) { return ladder.method == method; };
    if (std::none_of(result.ladders.begin(), result.ladders.end(), is_it)) continue;
    print(method, "%.4f", [&](double error) { return least_cost(result.ladders, error, is_it); });
  }
  const auto print_ratio = [&](const char* name, std::optional<double> CostRatios::*ratio) {
    print(name, "%.2fx", [&](double error) { return cost_ratios(result.ladders, error).*ratio; });
  };
  print_ratio("any fixed step / tolerance", &CostRatios::fixed_over_controlled);
  print_ratio("implicit fixed step / tolerance", &CostRatios::implicit_over_controlled);
  print_ratio("implicit fixed step / verlet", &CostRatios::implicit_over_explicit);
  if (std::any_of(result.ladders.begin(), result.ladders.end(),
                  [](const CostLadder& ladder) { return ladder.is_peer; })) {
    print_ratio("peers / tolerance", &CostRatios::peers_over_controlled);
    print_ratio("peers / verlet", &CostRatios::peers_over_explicit);
  }
  std::printf("\n");
}

nlohmann::ordered_json json_of(const Result& result) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Row& row : result.rows) {
    nlohmann::ordered_json entry{{"method", row.method}, {"setting", row.setting},
                                 {"cpu_s", row.cpu},     {"error_m", nullptr},
                                 {"steps", row.steps},   {"energy_change_j", nullptr},
                                 {"newton", nullptr},    {"linear", nullptr}};
    if (row.own) {
      entry["energy_change_j"] = row.own->energy_change;
      entry["newton"] = row.own->newton;
      entry["linear"] = row.own->linear;
    }
    if (row.error) entry["error_m"] = *row.error;
    if (row.is_bound) entry["error_is_bound"] = true;
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
  for (const std::string& method : accuracy_methods()) {
    PlotSeries series{method, {}, {}};
    std::vector<Row> rows;
    for (const Row& row : result.rows) {
      if (row.method == method && row.error && *row.error > 0) rows.push_back(row);
    }
    // The variants of another library's method share one line.
    if (!rows.empty() && !rows.front().own) rows = best_of(std::move(rows));
    for (const Row& row : rows) {
      series.dashed = !row.own;
      series.x.push_back(*row.error);
      series.y.push_back(row.cpu);
    }
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  write_svg(chart, path);
}

// Returns the path of a case's plot. Cases that share one --plot get their own: NAME_CASE.svg.
std::filesystem::path plot_path(const AccuracyOptions& options, const std::string& name) {
  if (options.cases.size() == 1) return options.plot;
  std::filesystem::path path = options.plot;
  return path.replace_filename(path.stem().string() + "_" + name + path.extension().string());
}

bool is_wanted(const AccuracyOptions& options, const char* method) {
  return options.methods.empty() ||
         std::find(options.methods.begin(), options.methods.end(), method) != options.methods.end();
}

}  // namespace

std::vector<std::string> accuracy_methods() {
  std::vector<std::string> names;
  for (const Ladder& ladder : method_ladders()) names.emplace_back(ladder.name);
  for (const ClothMethod& method : cloth_methods()) names.emplace_back(method.name);
  return names;
}

int run_accuracy(const AccuracyOptions& options) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  bool right = true;
  for (const std::string& path : options.cases) {
    // The ladders replace the case's own method and its settings.
    Case source = read_case(path, options.overrides);
    choose_accuracy(source);
    Result result{
        std::filesystem::path(path).stem().string(), reference_of(source, options), {}, {}};
    if (result.reference.positions.empty()) {
      std::fprintf(stderr, "%s: the references agree nowhere within %s m\n", path.c_str(),
                   number_text(options.certainty).c_str());
      right = false;
      continue;
    }
    for (const Ladder& ladder : method_ladders()) {
      if (is_wanted(options, ladder.name)) climb(source, ladder, options, result);
    }
    const auto scene = build_scene(source);
    for (const ClothMethod& method : cloth_methods()) {
      if (is_wanted(options, method.name)) climb(*scene, method, options, result);
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
