// Time and memory of a run against the size of its images.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/experiments.h"
#include "bench/run_cost.h"
#include "sim/case/case_reader.h"

namespace weft::bench {

namespace {

struct Row {
  int n = 0;
  RunCost cost;
  double bytes_per_vertex = 0;  // beyond those of the program
  double exponent = 0;          // e: step time ~ vertices^e, from the first size to this one
};

nlohmann::ordered_json json_of(const Row& row) {
  return {{"n", row.n},
          {"vertices", row.cost.vertices},
          {"steps", row.cost.steps},
          {"cpu_s_per_step", row.cost.cpu},
          {"exponent", row.exponent},
          {"linear_iterations_per_step", row.cost.linear_iterations},
          {"linear_iterations_per_solve", row.cost.iterations_per_solve()},
          {"bytes_per_vertex", row.bytes_per_vertex}};
}

}  // namespace

int run_scaling(const ScalingOptions& options) {
  const sim::Case source = sim::read_case(options.path, options.overrides);
  const double program = cost_of_run(with_image(source, tiny_image), options.steps).peak_bytes;
  if (!options.json) {
    std::printf(
        "%s, %d steps each; time of the median step; memory beyond that of %d x %d vertices\n"
        "%6s %10s %6s %12s %10s %14s %10s %10s\n",
        options.path.c_str(), options.steps, tiny_image, tiny_image, "n", "vertices", "steps",
        "CPU s/step", "exponent", "iterations", "per solve", "kB/vertex");
  }
  std::vector<Row> rows;
  bool finished = true;
  for (int n : options.sizes) {
    Row row{n, cost_of_run(with_image(source, n), options.steps)};
    const RunCost& cost = row.cost;
    row.bytes_per_vertex = (cost.peak_bytes - program) / cost.vertices;
    if (!rows.empty())
      row.exponent = std::log(cost.cpu / rows[0].cost.cpu) /
                     std::log(static_cast<double>(cost.vertices) / rows[0].cost.vertices);
    rows.push_back(row);
    finished = finished && cost.steps == options.steps;
    if (options.json) continue;
    std::printf("%6d %10d %6d %12.4f %10.3f %14.1f %10.2f %10.3f\n", n, cost.vertices, cost.steps,
                cost.cpu, row.exponent, cost.linear_iterations, cost.iterations_per_solve(),
                row.bytes_per_vertex / 1e3);
    std::fflush(stdout);
  }
  if (options.json) {
    nlohmann::ordered_json json;
    for (const Row& row : rows) json["rows"].push_back(json_of(row));
    std::printf("%s\n", json.dump(2).c_str());
  }
  return finished ? 0 : 1;
}

}  // namespace weft::bench
