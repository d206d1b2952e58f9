// Settings against errors on scenes with converged references: the table behind time.accuracy, and
// its verification on other scenes.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bench/calibration_scenes.h"
#include "bench/experiments.h"
#include "bench/reference_run.h"
#include "sim/accuracy/accuracy_choice.h"
#include "sim/accuracy/accuracy_pilot.h"
#include "sim/accuracy/error_monitor.h"
#include "sim/case/case_checks.h"
#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

using namespace sim;

constexpr int samples = 20;  // times at which a run is compared
// The share `wanted_share` of a rung's scenes should have errors within `wanted_factor` of the
// table's. A rung is left out if that takes more than `most_factor`, or if a scene's error exceeds
// `worst_factor` times the table's.
constexpr double wanted_share = 0.9;
constexpr double wanted_factor = 3;
constexpr double most_factor = 8;
constexpr double worst_factor = 10;

struct Ladder {
  const char* method;
  double first, divisor;
  int count;
};
constexpr Ladder ladders[] = {
    {"cvode", 2e-3, std::sqrt(10.0), 9},
    {"arkode", 2e-3, std::sqrt(10.0), 7},
    {"euler", 2e-2, std::sqrt(10.0), 6},
    {"linear-euler", 1.0 / 15, 2, 6},
};

const CalibratedMethod& method_named(const std::string& name) {
  return *std::ranges::find(calibrated_methods(), name, &CalibratedMethod::name);
}

struct Measurement {
  std::string scene;
  bool meetings = false;
  double error_rate = std::numeric_limits<double>::infinity();  // m/s; infinite for a failed run
  double cost = 0;                                              // s per simulated second
};

struct Rung {
  const Ladder* ladder = nullptr;
  double setting = 0;
  std::vector<Measurement> measurements;
};

// The row of the table for a rung and scenes of one kind, and its basis.
struct Fit {
  CalibrationRow row{};
  double low = 0, high = 0;  // m/s: between them lies the wanted share of the scenes
  double worst = 0;          // m/s
  int scenes = 0;
  bool usable = false;
};

double largest_error(const TimedRun& run, const Reference& reference) {
  double largest = 0;
  for (std::size_t i = 0; i < run.positions.size(); ++i) {
    largest = std::max(largest, rms_distance(run.positions[i], reference.positions[i]));
  }
  return std::isfinite(largest) ? largest : std::numeric_limits<double>::infinity();
}

// Finds the reference of a scene. Returns nothing, and reports it, if the references part before
// the end: then errors cannot be measured.
std::optional<Reference> reference_of(const CalibrationScene& scene, const Case& source,
                                      const CalibrateOptions& options) {
  Reference reference = find_reference(source, sample_times(source.time.duration, samples),
                                       {.tolerance = options.reference_tolerance,
                                        .certainty = options.certainty,
                                        .budget = options.budget});
  if (reference.positions.size() == samples) return reference;
  std::fprintf(stderr, "%s: the references agree within %s m until t = %s s only\n", scene.name,
               number_text(options.certainty).c_str(), number_text(reference.horizon).c_str());
  return std::nullopt;
}

bool is_wanted(const std::vector<std::string>& names, const char* name) {
  return names.empty() || std::ranges::find(names, name) != names.end();
}

// Climbs the ladders on one scene, each until a run exceeds the budget.
void measure(const CalibrationScene& scene, const CalibrateOptions& options,
             std::vector<Rung>& rungs) {
  const Case source = case_of(scene);
  const auto reference = reference_of(scene, source, options);
  if (!reference) return;
  std::fprintf(stderr, "%s: references agree to %.1e m\n", scene.name, reference->agreement);
  for (Rung& rung : rungs) {
    const CalibratedMethod& method = method_named(rung.ladder->method);
    Case timed = source;
    apply_setting(timed.time, method, rung.setting);
    const double limit = position_tolerance_limit(source);
    // Contact does not allow this tolerance, so time.accuracy never chooses it.
    if (!method.by_step && rung.setting > limit) continue;
    timed.time.position_tolerance = std::min(timed.time.position_tolerance, limit);
    const TimedRun run = simulate(timed, reference->times, options.budget);
    Measurement measurement{scene.name, has_meetings(source)};
    measurement.cost = run.cpu / source.time.duration;
    if (run.failure.empty()) {
      measurement.error_rate = largest_error(run, *reference) / source.time.duration;
    }
    rung.measurements.push_back(measurement);
  }
}

// Finds the narrowest window on a logarithmic scale with the wanted share of the scenes. Its middle
// goes into the table. Scenes above and below count alike.
Fit fit(const Rung& rung, bool meetings) {
  std::vector<double> rates;
  double log_cost = 0;
  for (const Measurement& each : rung.measurements) {
    if (each.meetings != meetings) continue;
    rates.push_back(each.error_rate);
    log_cost += std::log(each.cost);
  }
  Fit result;
  result.scenes = static_cast<int>(rates.size());
  result.row = {rung.ladder->method, meetings, rung.setting, 0, 0, 0};
  if (rates.empty()) return result;
  std::ranges::sort(rates);
  const auto inside =
      static_cast<std::size_t>(std::ceil(wanted_share * static_cast<double>(rates.size())));
  double narrowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + inside <= rates.size(); ++i) {
    const double ratio = rates[i + inside - 1] / rates[i];
    if (!(ratio < narrowest)) continue;
    narrowest = ratio;
    result.low = rates[i];
    result.high = rates[i + inside - 1];
  }
  result.row.error_rate = std::sqrt(result.low * result.high);
  result.row.cost = std::exp(log_cost / static_cast<double>(rates.size()));
  result.worst = rates.back();
  result.row.factor = std::sqrt(narrowest);
  result.usable =
      result.row.factor <= most_factor && result.worst <= worst_factor * result.row.error_rate;
  return result;
}

// Returns the rows for the table: the longest series of usable rungs whose errors grow with the
// setting.
std::vector<CalibrationRow> rows_of(const std::vector<Fit>& from_fine) {
  std::vector<CalibrationRow> rows, longest;
  for (const Fit& each : from_fine) {
    if (!each.usable) {
      rows.clear();
    } else if (rows.empty() || each.row.error_rate > rows.back().error_rate) {
      rows.push_back(each.row);
    }
    if (rows.size() > longest.size()) longest = rows;
  }
  if (longest.size() < 2) longest.clear();
  return longest;
}

std::vector<Fit> fits_of(const std::vector<Rung>& rungs, const Ladder& ladder, bool meetings) {
  std::vector<Fit> from_fine;
  for (auto rung = rungs.rbegin(); rung != rungs.rend(); ++rung) {
    if (rung->ladder != &ladder) continue;
    const Fit each = fit(*rung, meetings);
    if (each.scenes > 0) from_fine.push_back(each);
  }
  return from_fine;
}

std::string table_line(const CalibrationRow& row) {
  char text[160];
  std::snprintf(text, sizeof text, "{\"%s\", %s, %.3e, %.3e, %.2f, %.3e},\n", row.method,
                row.meetings ? "true" : "false", row.setting, row.error_rate, row.factor, row.cost);
  return text;
}

void print_fit(const Fit& each) {
  std::printf("%-13s %-5s %10.2e %12.3e %7.2f %10.2e %10.2e %10.2e %7d %10.3g  %s\n",
              each.row.method, each.row.meetings ? "yes" : "no", each.row.setting,
              each.row.error_rate, each.row.factor, each.low, each.high, each.worst, each.scenes,
              each.row.cost, each.usable ? "yes" : "no");
}

void plot(const std::vector<Rung>& rungs, const std::vector<CalibrationRow>& table,
          const std::filesystem::path& path) {
  Plot chart;
  chart.title = "Calibration: error against setting";
  chart.note = "lines: what time.accuracy goes by; marks: scenes";
  chart.x.title = "position_tolerance, m (linear-euler: step, s)";
  chart.y.title = "error over duration, m/s";
  for (const Ladder& ladder : ladders) {
    for (const bool meetings : {false, true}) {
      const std::string name = std::string(ladder.method) + (meetings ? ", bodies meet" : "");
      PlotSeries line{name, {}, {}}, marks{name + ": scenes", {}, {}, false};
      for (const CalibrationRow& row : table) {
        if (std::string(row.method) != ladder.method || row.meetings != meetings) continue;
        line.x.push_back(row.setting);
        line.y.push_back(row.error_rate);
      }
      for (const Rung& rung : rungs) {
        for (const Measurement& each : rung.measurements) {
          const bool shown = rung.ladder == &ladder && each.meetings == meetings &&
                             std::isfinite(each.error_rate) && each.error_rate > 0;
          if (!shown) continue;
          marks.x.push_back(rung.setting);
          marks.y.push_back(each.error_rate);
        }
      }
      if (!line.x.empty()) chart.series.push_back(std::move(line));
      if (!marks.x.empty()) chart.series.push_back(std::move(marks));
    }
  }
  write_svg(chart, path);
}

int calibrate(const CalibrateOptions& options) {
  std::vector<Rung> rungs;
  for (const Ladder& ladder : ladders) {
    for (int i = 0; i < ladder.count; ++i) {
      rungs.push_back({&ladder, ladder.first / std::pow(ladder.divisor, i), {}});
    }
  }
  for (const CalibrationScene& scene : calibration_scenes()) {
    if (!scene.held_out && is_wanted(options.scenes, scene.name)) measure(scene, options, rungs);
  }
  std::printf("%-13s %-5s %10s %12s %7s %10s %10s %10s %7s %10s  %s\n", "method", "meets",
              "setting", "error m/s", "factor", "low", "high", "worst", "scenes", "CPU s/s",
              "usable");
  std::vector<CalibrationRow> table;
  std::string text =
      "// Written by `weft bench calibrate`: method, whether bodies meet, setting (m, of steps "
      "s),\n"
      "// error over duration (m/s), factor within which nine of ten scenes had it, CPU time per\n"
      "// simulated second.\n";
  for (const bool meetings : {false, true}) {
    for (const Ladder& ladder : ladders) {
      const std::vector<Fit> fits = fits_of(rungs, ladder, meetings);
      for (const Fit& each : fits) print_fit(each);
      for (const CalibrationRow& row : rows_of(fits)) {
        table.push_back(row);
        text += table_line(row);
      }
    }
  }
  if (!options.output.empty()) write_text(text, options.output);
  if (!options.plot.empty()) plot(rungs, table, options.plot);
  return table.empty() ? 1 : 0;
}

// The result of asking for an accuracy on one scene; empty if that is refused.
struct Achieved {
  double error = 0;  // m
  bool by_stable_steps = false;
  // Verlet is chosen if it is cheapest, and may then be too exact: its stable steps can be shorter
  // than the accuracy requires.
  bool is_right(double asked) const {
    return error <= wanted_factor * asked && (by_stable_steps || error >= asked / wanted_factor);
  }
};
std::optional<Achieved> achieved(const CalibrationScene& scene, double asked,
                                 const Reference& reference, const CalibrateOptions& options) {
  try {
    Case source = case_of(scene, {"time.accuracy=" + number_text(asked)});
    correct_accuracy(source);
    const TimedRun run = simulate(source, reference.times, options.budget);
    const double error = run.failure.empty() ? largest_error(run, reference)
                                             : std::numeric_limits<double>::infinity();
    std::printf("%-16s %9.1e %11.3e %9.2f %9.3f  %s\n", scene.name, asked, error, error / asked,
                run.cpu,
                run.failure.empty() ? source.accuracy_choice.c_str() : run.failure.c_str());
    return Achieved{error, source.time.method == TimeMethod::verlet};
  } catch (const CaseError& refusal) {
    std::printf("%-16s %9.1e refused: %s\n", scene.name, asked, refusal.what());
    return std::nullopt;
  }
}

int verify(const CalibrateOptions& options) {
  std::printf("%-16s %9s %11s %9s %9s  %s\n", "scene", "asked m", "achieved m", "ratio", "CPU s",
              "choice");
  std::vector<int> right(options.asked.size()), all(right), by_stable_steps(right);
  for (const CalibrationScene& scene : calibration_scenes()) {
    if (!scene.held_out || !is_wanted(options.scenes, scene.name)) continue;
    const auto reference = reference_of(scene, case_of(scene), options);
    for (std::size_t i = 0; i < options.asked.size(); ++i) {
      ++all[i];
      if (!reference) continue;
      const auto found = achieved(scene, options.asked[i], *reference, options);
      if (!found) continue;
      right[i] += found->is_right(options.asked[i]) ? 1 : 0;
      by_stable_steps[i] += found->by_stable_steps ? 1 : 0;
    }
    std::fflush(stdout);
  }
  bool good = true;
  for (std::size_t i = 0; i < options.asked.size(); ++i) {
    std::printf("%d of %d scenes within a factor %s of %s m (%d by verlet, at least as exact)\n",
                right[i], all[i], number_text(wanted_factor).c_str(),
                number_text(options.asked[i]).c_str(), by_stable_steps[i]);
    good &= right[i] >= wanted_share * all[i];
  }
  return good ? 0 : 1;
}

}  // namespace

std::vector<std::string> calibration_scene_names() {
  std::vector<std::string> names;
  for (const CalibrationScene& scene : calibration_scenes()) names.emplace_back(scene.name);
  return names;
}

int run_calibrate(const CalibrateOptions& options) {
  return options.verify ? verify(options) : calibrate(options);
}

}  // namespace weft::bench
