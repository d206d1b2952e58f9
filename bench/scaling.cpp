// Time and memory of a run against the size of its images.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "sim/accuracy/accuracy_choice.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/integrator/integrator.h"
#include "sim/scene/scene.h"
#include "sim/simulation/simulation.h"

namespace weft::bench {

namespace {

using namespace sim;

struct Row {
  int n = 0;
  int vertices = 0;
  int steps = 0;                // taken; fewer than requested if one failed
  double cpu = 0;               // s, median step
  double iterations = 0;        // linear, per step
  double bytes_per_vertex = 0;  // beyond those of a scene of 5 x 5 vertices
  double exponent = 0;          // e: step time ~ vertices^e, from the first size to this one
};

// Results that a child process reports.
struct Told {
  int vertices = 0, steps = 0;
  double cpu = 0, iterations = 0;
};

Told measure(const ScalingOptions& options, int n) {
  Case source = read_case(options.path, options.overrides);
  source.body.at(0).shape.resolution = {n, n};
  choose_accuracy(source);
  Simulation simulation(build_scene(source));
  Told told{simulation.scene().dynamic_particles};
  std::vector<double> times;
  for (; told.steps < options.steps; ++told.steps) {
    std::optional<Failure> failure;
    times.push_back(cpu_time_of([&] { failure = simulation.step(); }));
    if (!failure) continue;
    std::fprintf(stderr, "%d: %s\n", n, failure->text.c_str());
    break;
  }
  told.cpu = median(times);
  told.iterations =
      static_cast<double>(simulation.counts().linear_iterations) / std::max(1, told.steps);
  return told;
}

// Measures one size in a separate process, whose peak memory is then that of this size alone.
Told measure_apart(const ScalingOptions& options, int n, double& peak_bytes) {
  int pipe_ends[2];
  if (pipe(pipe_ends) != 0) throw std::runtime_error("no pipe to a child process");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child process");
  if (child == 0) {
    int code = 1;
    try {
      const Told told = measure(options, n);
      if (write(pipe_ends[1], &told, sizeof told) == sizeof told) code = 0;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "weft bench: %s\n", error.what());
    }
    _exit(code);
  }
  close(pipe_ends[1]);
  Told told;
  const bool has_told = read(pipe_ends[0], &told, sizeof told) == sizeof told;
  close(pipe_ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (!has_told) throw std::runtime_error("the run of size " + std::to_string(n) + " ended early");
  peak_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
  return told;
}

}  // namespace

int run_scaling(const ScalingOptions& options) {
  double tiny_peak = 0;
  measure_apart(options, 5, tiny_peak);
  if (!options.json) {
    std::printf(
        "%s, %d steps each; time of the median step; memory beyond that of 5 x 5 vertices\n"
        "%6s %10s %6s %12s %10s %14s %10s\n",
        options.path.c_str(), options.steps, "n", "vertices", "steps", "CPU s/step", "exponent",
        "iterations", "kB/vertex");
  }
  std::vector<Row> rows;
  bool finished = true;
  for (int n : options.sizes) {
    double peak = 0;
    const Told told = measure_apart(options, n, peak);
    Row row{n, told.vertices, told.steps, told.cpu, told.iterations};
    row.bytes_per_vertex = (peak - tiny_peak) / row.vertices;
    if (!rows.empty())
      row.exponent = std::log(row.cpu / rows[0].cpu) /
                     std::log(static_cast<double>(row.vertices) / rows[0].vertices);
    rows.push_back(row);
    finished = finished && row.steps == options.steps;
    if (options.json) continue;
    std::printf("%6d %10d %6d %12.4f %10.3f %14.1f %10.3f\n", n, row.vertices, row.steps, row.cpu,
                row.exponent, row.iterations, row.bytes_per_vertex / 1e3);
    std::fflush(stdout);
  }
  if (options.json) {
    nlohmann::ordered_json json;
    for (const Row& row : rows) {
      json["rows"].push_back({{"n", row.n},
                              {"vertices", row.vertices},
                              {"steps", row.steps},
                              {"cpu_s_per_step", row.cpu},
                              {"exponent", row.exponent},
                              {"linear_iterations_per_step", row.iterations},
                              {"bytes_per_vertex", row.bytes_per_vertex}});
    }
    std::printf("%s\n", json.dump(2).c_str());
  }
  return finished ? 0 : 1;
}

}  // namespace weft::bench
