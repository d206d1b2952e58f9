// Shells against closed forms and published figures: value, error and CPU time by resolution.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bench/shell_checks.h"
#include "sim/case/case_reader.h"
#include "sim/run/make_simulation.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

using namespace sim;

struct Row {
  const ShellCheck* check = nullptr;
  CheckedImage image;
  int control_points = 0;
  Measured worst;
  double cpu_s = 0;
  std::string failure;  // empty: none

  double error() const { return std::abs(worst.value - worst.reference.value) / worst.scale; }
  bool holds() const { return failure.empty() && (image.limit == 0 || error() <= image.limit); }
};

std::string list_of(const std::vector<int>& numbers) {
  std::string text;
  for (const int each : numbers) text += (text.empty() ? "" : ", ") + std::to_string(each);
  return text;
}

Simulation simulation_of(const ShellCheck& check, const CheckedImage& image) {
  std::vector<std::string> overrides = check.overrides;
  overrides.push_back("body." + check.body + ".shape.resolution=[" + list_of(image.resolution) +
                      ']');
  return make_simulation(read_case(
      std::string(WEFT_CASES_DIR) + "/benchmarks/" + check.case_name + ".toml", overrides));
}

void measure_frame(Simulation& simulation, const std::vector<Vec3>& start, int frame, Row& row) {
  const FramedBody body(start, simulation.position(row.check->body), row.image.resolution[1]);
  for (Measured& each : row.check->measure(body, frame)) {
    Row other = row;
    other.worst = std::move(each);
    if (row.worst.quantity.empty() || other.error() > row.error()) row.worst = other.worst;
  }
}

// Runs the case from frame to frame and keeps the worst of all that is measured.
Row run_check(const ShellCheck& check, const CheckedImage& image) {
  Row row{.check = &check, .image = image};
  row.control_points = image.resolution[0] * image.resolution[1];
  row.cpu_s = cpu_time_of([&] {
    Simulation simulation = simulation_of(check, image);
    const TimeCase& time = simulation.scene().source.time;
    const std::vector<Vec3> start = simulation.position(check.body);
    const int frames = static_cast<int>(std::lround(time.duration * time.frames_per_second));
    for (int frame = 0; frame <= frames; ++frame) {
      const double until = frame / time.frames_per_second;
      if (until > simulation.time()) {
        if (const auto failure = simulation.advance(until - simulation.time())) {
          row.failure = failure->text;
          return;
        }
      }
      measure_frame(simulation, start, frame, row);
    }
  });
  return row;
}

nlohmann::json json_of(const Row& row) {
  nlohmann::json json{{"check", row.check->name},
                      {"case", "cases/benchmarks/" + row.check->case_name + ".toml"},
                      {"resolution", row.image.resolution},
                      {"cpu_s", row.cpu_s},
                      {"limit", nullptr}};
  if (row.image.limit > 0) json["limit"] = row.image.limit;
  if (!row.failure.empty()) {
    json["failure"] = row.failure;
    return json;
  }
  json["quantity"] = row.worst.quantity;
  json["value"] = row.worst.value;
  json["reference"] = row.worst.reference.value;
  json["error"] = row.error();
  json["source"] = row.worst.reference.source;
  return json;
}

void print_row(const Row& row) {
  std::printf("%-34s %4d x %-4d ", row.check->name.c_str(), row.image.resolution[0],
              row.image.resolution[1]);
  if (!row.failure.empty()) {
    std::printf("%s\n", row.failure.c_str());
    return;
  }
  char limit[32] = "-";
  if (row.image.limit > 0) std::snprintf(limit, sizeof limit, "%.3g %%", 100 * row.image.limit);
  std::printf("%-11s %12.6g %12.6g %9.4f %% %8s %9.3f%s\n", row.worst.quantity.c_str(),
              row.worst.value, row.worst.reference.value, 100 * row.error(), limit, row.cpu_s,
              row.holds() ? "" : "  beyond its limit");
}

// Charts of error against control points, and of error against CPU time.
void write_plots(const std::vector<Row>& rows, const std::filesystem::path& directory) {
  Plot by_points{"Shells: error against control points",
                 "weft bench shells",
                 {"control points"},
                 {"relative error"},
                 {}};
  Plot by_time{"Shells: error against CPU time",
               "weft bench shells",
               {"CPU time of the whole case, s"},
               {"relative error"},
               {}};
  for (const Row& row : rows) {
    if (!row.failure.empty() || row.error() == 0) continue;
    for (Plot* plot : {&by_points, &by_time}) {
      if (plot->series.empty() || plot->series.back().name != row.check->name)
        plot->series.push_back({.name = row.check->name});
      plot->series.back().x.push_back(plot == &by_points ? row.control_points : row.cpu_s);
      plot->series.back().y.push_back(row.error());
    }
  }
  write_svg(by_points, directory / "shells_convergence.svg");
  write_svg(by_time, directory / "shells_work_precision.svg");
}

}  // namespace

std::vector<std::string> shell_check_names() {
  std::vector<std::string> names;
  for (const ShellCheck& each : shell_checks()) {
    if (std::ranges::find(names, each.case_name) == names.end()) names.push_back(each.case_name);
  }
  return names;
}

int run_shells(const ShellsOptions& options) {
  if (!options.json) {
    std::printf("%-34s %-11s %-11s %12s %12s %11s %8s %9s\n", "check", "image", "quantity", "value",
                "reference", "error", "limit", "cpu_s");
  }
  std::vector<Row> rows;
  for (const ShellCheck& check : shell_checks()) {
    if (!options.cases.empty() &&
        std::ranges::find(options.cases, check.case_name) == options.cases.end())
      continue;
    for (const CheckedImage& image : check.images) {
      rows.push_back(run_check(check, image));
      if (!options.json) print_row(rows.back());
    }
  }
  if (options.json) {
    nlohmann::json all = nlohmann::json::array();
    for (const Row& row : rows) all.push_back(json_of(row));
    std::printf("%s\n", nlohmann::json{{"rows", all}}.dump(2).c_str());
  }
  if (!options.plots.empty()) write_plots(rows, options.plots);
  return std::ranges::all_of(rows, &Row::holds) ? 0 : 1;
}

}  // namespace weft::bench
