#include "bench/shell_solver_rows.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "bench/temporary_folder.h"
#include "bench/timed_command.h"

namespace weft::bench {

namespace {

constexpr const char* case_path = "cases/vibrating_plate.toml";

// Allowed difference of iterations from those of the smallest image, as a part of these.
constexpr double allowed_growth = 0.5;

// Returns the rows of `weft bench scaling` for the plate. It runs as a program of its own, because
// the threads of this process would disturb the processes in which it measures memory.
nlohmann::json scaling_rows() {
  const TemporaryFolder folder;
  const TimedCommand command = run_command(
      {std::filesystem::read_symlink("/proc/self/exe"), "scaling",
       std::string(WEFT_SOURCE_DIR "/") + case_path, "--json", "--sizes", "17,33,65,129", "--steps",
       "3", "--set", "time.method=euler", "--set", "time.step=1e-4", "--set",
       "time.preconditioner=multigrid", "--set", "compute.threads=1"},
      folder.path());
  if (!command.is_well) throw std::runtime_error("weft bench scaling failed: " + command.output);
  return nlohmann::json::parse(command.output).at("rows");
}

// Returns a row of one size, with the value of the smallest size as its reference.
CheckRow row_of(const std::string& check, const std::string& quantity, const nlohmann::json& size,
                double value, double reference) {
  CheckRow row;
  row.check = check;
  row.case_path = case_path;
  const int n = size.at("n");
  row.resolution = {n, n};
  row.points = size.at("vertices");
  row.quantity = quantity;
  row.value = value;
  row.reference = row.scale = reference;
  row.cpu_s = size.at("cpu_s_per_step");
  row.source = "the same at 17 x 17";
  return row;
}

std::vector<CheckRow> rows_of(const nlohmann::json& sizes) {
  std::vector<CheckRow> iterations, memory;
  for (const nlohmann::json& size : sizes) {
    const double per_solve = size.at("linear_iterations_per_solve");
    const double kilobytes = size.at("bytes_per_vertex").get<double>() / 1e3;
    CheckRow& row =
        iterations.emplace_back(row_of("multigrid iterations", "per solve", size, per_solve,
                                       iterations.empty() ? per_solve : iterations.front().value));
    row.bound = Bound::error;
    row.limit = allowed_growth;
    memory.push_back(row_of("memory per vertex", "kB", size, kilobytes, kilobytes));
    memory.back().bound = Bound::reported;
    memory.back().source.clear();
  }
  iterations.insert(iterations.end(), memory.begin(), memory.end());
  return iterations;
}

}  // namespace

void shell_solver_rows(const std::function<void(const CheckRow&)>& done) {
  std::vector<CheckRow> rows;
  try {
    rows = rows_of(scaling_rows());
  } catch (const std::exception& error) {
    CheckRow& row = rows.emplace_back();
    row.check = "multigrid iterations";
    row.case_path = case_path;
    row.failure = error.what();
  }
  for (const CheckRow& row : rows) done(row);
}

}  // namespace weft::bench
