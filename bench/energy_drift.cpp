// Run time against the drift of energy, for a motion that conserves it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/experiments.h"
#include "bench/method_ladders.h"
#include "bench/reference_run.h"
#include "sim/accuracy/accuracy_choice.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

using namespace sim;

constexpr int samples = 500;  // of the energy, per run

struct Row {
  std::string method, setting;
  double cpu = 0;  // s
  // Change of the total energy since the start, divided by the largest kinetic energy: the largest
  // magnitude, and the value at the end. Empty if the run fails.
  std::optional<double> largest, last;
  std::int64_t steps = 0;
  std::string failure;
};

Row measure(const Case& source, const Ladder& ladder, double setting, double budget) {
  Case timed = source;
  ladder.apply(timed.time, setting);
  const TimedRun run = simulate(timed, sample_times(source.time.duration, samples), budget);
  Row row{ladder.name, setting_text(ladder, setting), run.cpu, {}, {}, run.counts.steps,
          run.failure};
  if (!run.failure.empty()) return row;
  double kinetic = 0, change = 0, largest = 0;
  for (const Energies& now : run.energies) {
    kinetic = std::max(kinetic, now.kinetic);
    change = now.total() - run.energies.front().total();
    largest = std::max(largest, std::abs(change));
  }
  row.largest = largest / kinetic;
  row.last = change / kinetic;
  return row;
}

bool is_wanted(const EnergyDriftOptions& options, const std::string& method) {
  return options.methods.empty() ||
         std::find(options.methods.begin(), options.methods.end(), method) != options.methods.end();
}

std::vector<Row> measure_all(const Case& source, const EnergyDriftOptions& options) {
  std::vector<Row> rows;
  for (const Ladder& ladder : method_ladders()) {
    if (!is_wanted(options, ladder.name)) continue;
    double setting = ladder.first;
    LadderEnd end;
    for (int i = 0; i < ladder.count; ++i, setting /= ladder.divisor) {
      rows.push_back(measure(source, ladder, setting, options.budget));
      const Row& row = rows.back();
      std::fprintf(stderr, "%s, %s: %s\n", row.method.c_str(), row.setting.c_str(),
                   row.largest ? number_text(*row.largest).c_str() : row.failure.c_str());
      if (end.is_reached(row.cpu > options.budget)) break;
    }
  }
  return rows;
}

void print_table(const Case& source, const std::vector<Row>& rows) {
  std::printf("energy over %s s, as a share of the largest kinetic energy\n",
              number_text(source.time.duration).c_str());
  std::printf("%-18s %-22s %10s %9s %14s %12s\n", "method", "setting", "CPU s", "steps",
              "largest drift", "at the end");
  for (const Row& row : rows) {
    std::printf("%-18s %-22s %10.3f %9lld ", row.method.c_str(), row.setting.c_str(), row.cpu,
                static_cast<long long>(row.steps));
    if (row.largest)
      std::printf("%14.2e %+12.2e\n", *row.largest, *row.last);
    else
      std::printf("%s\n", row.failure.c_str());
  }
}

nlohmann::ordered_json json_of(const std::vector<Row>& rows) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    nlohmann::ordered_json entry{{"method", row.method},     {"setting", row.setting},
                                 {"cpu_s", row.cpu},         {"steps", row.steps},
                                 {"largest_drift", nullptr}, {"last_drift", nullptr}};
    if (row.largest) {
      entry["largest_drift"] = *row.largest;
      entry["last_drift"] = *row.last;
    } else {
      entry["failure"] = row.failure;
    }
    json.push_back(std::move(entry));
  }
  return {{"rows", std::move(json)}};
}

void plot(const Case& source, const std::vector<Row>& rows, const std::filesystem::path& path) {
  Plot chart;
  chart.title = "Run time against the drift of the energy";
  chart.note = "over " + number_text(source.time.duration) + " s, one thread";
  chart.x.title = "largest change of the energy, by the largest kinetic energy";
  chart.y.title = "CPU time, s";
  for (const Ladder& ladder : method_ladders()) {
    PlotSeries series{ladder.name, {}, {}};
    for (const Row& row : rows) {
      if (row.method != ladder.name || !row.largest || *row.largest <= 0) continue;
      series.x.push_back(*row.largest);
      series.y.push_back(row.cpu);
    }
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  write_svg(chart, path);
}

}  // namespace

int run_energy_drift(const EnergyDriftOptions& options) {
  Case source = read_case(options.path, options.overrides);
  choose_accuracy(source);
  const std::vector<Row> rows = measure_all(source, options);
  if (options.json)
    std::printf("%s\n", json_of(rows).dump(2).c_str());
  else
    print_table(source, rows);
  if (!options.plot.empty()) plot(source, rows, options.plot);
  return 0;
}

}  // namespace weft::bench
