#include "bench/calculix_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "bench/calculix.h"
#include "bench/case_check.h"
#include "bench/temporary_folder.h"
#include "bench/timed_command.h"
#include "sim/scene/pins.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

using sim::Case;
using sim::Vec3;

// A case that both programs run.
struct Contest {
  std::string name, case_name;
  bool is_linear = false;
  std::vector<std::string> figures;  // published: displacements of the loads along themselves
  std::vector<int> sides;            // Weft's control points along a side; the last: a reference
  std::vector<int> elements;         // of CalculiX along a side
};

const std::vector<Contest>& contests() {
  static const std::vector<Contest> all{
      {"hemisphere, full load",
       "hemisphere_full_load",
       false,
       {"hemisphere_full_load_outward", "hemisphere_full_load_inward"},
       {10, 12, 16, 20, 24, 32, 40, 64},
       {8, 14, 20, 28}},
      {"pinched cylinder",
       "pinched_cylinder",
       true,
       {"pinched_cylinder"},
       {9, 13, 17, 25, 33, 49, 97},
       {6, 8, 12, 16, 24}},
  };
  return all;
}

// Displacements of the loaded points along their forces, and the time they took.
struct Run {
  int side = 0;
  std::vector<double> along;  // m
  double cpu_s = 0;
};

// The displacements from which errors are measured.
struct Truth {
  std::string name;
  std::vector<double> along;  // m
  std::string source;
};

double error_of(const Run& run, const Truth& truth) {
  double worst = 0;
  for (std::size_t i = 0; i < truth.along.size(); ++i)
    worst = std::max(worst, std::abs(run.along.at(i) / truth.along[i] - 1));
  return worst;
}

Vec3 direction_of(const sim::LoadCase& load) {
  return load.force.curve()->values.back().normalized();
}

Run run_weft(const Contest& contest, int side) {
  const TemporaryFolder folder;
  const std::string path = benchmark_path(contest.case_name);
  const std::string n = std::to_string(side);
  const TimedCommand command =
      run_command({weft_command(), "run", path, "--quiet", "-o", folder.path(), "--set",
                   "compute.threads=1", "--set", "output.precision=float64", "--set",
                   "body.0.shape.resolution=[" + n + ", " + n + "]"},
                  folder.path());
  if (!command.is_well) throw std::runtime_error("weft run has failed:\n" + command.output);
  const Case source = sim::read_case(path, {});
  const sim::TrajectoryReader trajectory(folder.path(contest.case_name + ".h5"));
  const std::vector<Vec3> start = trajectory.positions(0, 0),
                          end = trajectory.positions(0, trajectory.frames() - 1);
  Run run{side, {}, command.cpu_s};
  for (const sim::LoadCase& load : source.load) {
    const int point = sim::select_vertices(load.vertices, load.location, "load",
                                           trajectory.bodies()[0].atlas, start)
                          .at(0);
    run.along.push_back(direction_of(load).dot(end[point] - start[point]));
  }
  return run;
}

Run run_calculix(const Contest& contest, int elements) {
  const Case source = sim::read_case(benchmark_path(contest.case_name), {});
  const CalculixRun done = bench::run_calculix(calculix_deck(source, elements, contest.is_linear));
  Run run{elements, {}, done.cpu_s};
  for (std::size_t i = 0; i < source.load.size(); ++i)
    run.along.push_back(direction_of(source.load[i]).dot(done.displacements.at(i)));
  return run;
}

// Returns the time (s) that runs of rising size take for an error, by a straight line between
// logarithms where the error first falls below it; empty if none is as exact. The coarsest run
// counts as it is if its error is smaller.
std::optional<double> time_for(double error, const std::vector<Run>& runs, const Truth& truth) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const double fine = error_of(runs[i], truth);
    if (fine > error) continue;
    if (i == 0) return runs[i].cpu_s;
    const double coarse = error_of(runs[i - 1], truth);
    const double s = std::log(coarse / error) / std::log(coarse / fine);
    return runs[i - 1].cpu_s * std::pow(runs[i].cpu_s / runs[i - 1].cpu_s, s);
  }
  return std::nullopt;
}

CheckRow row_of(const Contest& contest, const std::string& program, const Run& run,
                const Truth& truth) {
  CheckRow row{.check = contest.name + ": " + program,
               .case_path = "cases/benchmarks/" + contest.case_name + ".toml",
               .resolution = {run.side, run.side},
               .cpu_s = run.cpu_s,
               .source = truth.source};
  for (std::size_t i = 0; i < run.along.size(); ++i) {
    const double error = std::abs(run.along[i] / truth.along[i] - 1);
    if (!row.quantity.empty() && error <= row.error()) continue;
    row.quantity = "load " + std::to_string(i + 1) + ", " + truth.name;
    row.value = run.along[i];
    row.reference = truth.along[i];
    row.scale = std::abs(truth.along[i]);
  }
  return row;
}

// The CPU time of a run of CalculiX over that of Weft for its error.
CheckRow ratio_of(const Contest& contest, const Run& calculix, const std::vector<Run>& weft,
                  const Truth& truth) {
  const double error = error_of(calculix, truth);
  char quantity[32];
  std::snprintf(quantity, sizeof quantity, "%.3g %%, ", 100 * error);
  CheckRow row{.check = contest.name + ": CalculiX / Weft",
               .case_path = "cases/benchmarks/" + contest.case_name + ".toml",
               .resolution = {calculix.side, calculix.side},
               .quantity = quantity + truth.name,
               .reference = 3,
               .scale = 3,
               .bound = Bound::wanted,
               .cpu_s = calculix.cpu_s,
               .source = "errors against " + truth.source};
  if (const auto time = time_for(error, weft, truth)) {
    row.value = calculix.cpu_s / *time;
  } else {
    row.skipped = true;
    row.failure = "no run of Weft has the error " + row.quantity;
  }
  return row;
}

Truth published(const Contest& contest) {
  Truth truth{"published", {}, {}};
  for (const std::string& name : contest.figures) {
    const ReferenceFigure figure = reference_figure(name);
    truth.along.push_back(figure.value);
    if (truth.source.empty()) truth.source = figure.source;
  }
  return truth;
}

void compare(const Contest& contest, const std::function<void(const CheckRow&)>& done) {
  std::vector<Run> weft, calculix;
  for (const int side : contest.sides) weft.push_back(run_weft(contest, side));
  const std::string n = std::to_string(weft.back().side);
  const Truth truths[] = {published(contest),
                          {"fine Weft", weft.back().along, "Weft on " + n + " x " + n}};
  weft.pop_back();
  for (const int side : contest.elements) calculix.push_back(run_calculix(contest, side));
  for (const Truth& truth : truths) {
    for (const Run& run : weft) done(row_of(contest, "Weft", run, truth));
    for (const Run& run : calculix) done(row_of(contest, "CalculiX", run, truth));
    double best = std::numeric_limits<double>::infinity();
    for (const Run& run : calculix) {
      // A run counts if no smaller one is as exact.
      if (error_of(run, truth) >= best) continue;
      best = error_of(run, truth);
      done(ratio_of(contest, run, weft, truth));
    }
  }
}

}  // namespace

void compare_with_calculix(const std::function<void(const CheckRow&)>& done) {
  for (const Contest& contest : contests()) {
    if (has_calculix()) {
      compare(contest, done);
    } else {
      done({.check = contest.name + ": CalculiX / Weft",
            .failure = "CalculiX is not installed (Debian: calculix-ccx)",
            .skipped = true});
    }
  }
}

std::vector<std::string> comparison_names() {
  std::vector<std::string> names;
  for (const Contest& contest : contests()) {
    for (const char* program : {"Weft", "CalculiX", "CalculiX / Weft"})
      names.push_back(contest.name + ": " + program);
  }
  return names;
}

void write_comparison(const std::vector<CheckRow>& rows, const std::filesystem::path& directory) {
  sim::Plot plot{"Error against CPU time: Weft and CalculiX",
                 "weft bench shells; whole commands on one thread",
                 {"CPU time, s"},
                 {"relative error"},
                 {}};
  for (const CheckRow& row : rows) {
    if (!row.failure.empty() || row.bound == Bound::wanted || row.error() == 0) continue;
    const bool to_weft = row.source.starts_with("Weft");
    const std::string name = row.check + (to_weft ? " (fine Weft)" : "");
    const auto known = std::ranges::find(plot.series, name, &sim::PlotSeries::name);
    sim::PlotSeries& series = known == plot.series.end() ? plot.series.emplace_back() : *known;
    series.name = name;
    series.dashed = to_weft;
    series.x.push_back(row.cpu_s);
    series.y.push_back(row.error());
  }
  if (!plot.series.empty()) sim::write_svg(plot, directory / "shells_calculix.svg");
}

}  // namespace weft::bench
