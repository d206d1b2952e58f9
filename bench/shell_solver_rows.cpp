#include "bench/shell_solver_rows.h"

#include <stdexcept>
#include <string>
#include <vector>

#include "bench/run_cost.h"
#include "sim/case/case_reader.h"

namespace weft::bench {

namespace {

constexpr int sizes[] = {17, 33, 65, 129};
constexpr int steps = 3;

// Allowed difference of iterations from those of the smallest image, as a part of these.
constexpr double allowed_growth = 0.5;

sim::Case plate(int n) {
  return with_image(sim::read_case(WEFT_SOURCE_DIR "/cases/vibrating_plate.toml",
                                   {"time.method=\"euler\"", "time.step=1e-4",
                                    "time.preconditioner=\"multigrid\"", "compute.threads=1"}),
                    n);
}

CheckRow row_of(const std::string& check, int n, const std::string& quantity) {
  CheckRow row;
  row.check = check;
  row.case_path = "cases/vibrating_plate.toml";
  row.resolution = {n, n};
  row.points = n * n;
  row.quantity = quantity;
  return row;
}

}  // namespace

void shell_solver_rows(const std::function<void(const CheckRow&)>& done) {
  std::vector<CheckRow> memory;
  CheckRow first;
  const double program = cost_of_run(plate(tiny_image), 1).peak_bytes;
  for (const int n : sizes) {
    CheckRow solves = row_of("multigrid iterations", n, "per solve");
    CheckRow& bytes = memory.emplace_back(row_of("memory per vertex", n, "kB"));
    solves.bound = Bound::error;
    solves.limit = allowed_growth;
    solves.source = "the same at 17 x 17";
    bytes.bound = Bound::reported;
    try {
      const RunCost cost = cost_of_run(plate(n), steps);
      solves.cpu_s = bytes.cpu_s = steps * cost.cpu;
      if (cost.steps < steps) throw std::runtime_error("a step failed");
      solves.value = cost.iterations_per_solve();
      bytes.value = (cost.peak_bytes - program) / cost.vertices / 1e3;
    } catch (const std::exception& error) {
      solves.failure = bytes.failure = error.what();
    }
    if (n == sizes[0]) first = solves;
    solves.reference = solves.scale = first.value;
    if (solves.failure.empty() && first.value == 0) solves.failure = "no iterations at 17 x 17";
    done(solves);
  }
  for (const CheckRow& row : memory) done(row);
}

}  // namespace weft::bench
