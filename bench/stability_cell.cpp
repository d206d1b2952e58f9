#include "bench/stability_cell.h"

#include <cmath>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>

#include "bench/child_runs.h"
#include "bench/medians.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"
#include "sim/run/make_simulation.h"
#include "sim/simulation/cpu_limit.h"

namespace weft::bench {

namespace {

using namespace sim;

// Number of states of a run that are checked before the last one. Moving obstacles and pins need
// more, since they pass the cloth in less time.
constexpr int looks_at_rest = 25, looks_at_motion = 200;
constexpr double patience = 3;         // limits after which a step that does not end is a hang
constexpr double least_patience = 10;  // s

constexpr const char* names[outcome_count] = {"finished", "inexact",  "refused", "failed",
                                              "limited",  "too slow", "hung",    "not finite",
                                              "wrong",    "unclear",  "crashed"};

// Runs to the end of the case, a failure, or its limit.
void advance(Simulation& simulation, Judge& judge, const ConvergedEnd* converged, double tolerance,
             CellResult& result) {
  const double start = seconds(CLOCK_PROCESS_CPUTIME_ID);
  const Scene& scene = simulation.scene();
  const TimeCase& options = scene.source.time;
  CpuLimit limit(scene.source.compute.cpu_limit.value());
  simulation.set_reason_to_stop([&]() -> std::optional<Failure> {
    if (!limit.is_passed()) return std::nullopt;
    return limit.failure(simulation);
  });
  double next_look = 0, judging = 0;
  const int looks = something_is_moved(scene) ? looks_at_motion : looks_at_rest;
  const auto end_with = [&](Outcome outcome, std::string message) {
    result.outcome = outcome;
    result.message = std::move(message);
  };
  while (simulation.time() < options.duration * (1 - 1e-9)) {
    const auto failure = simulation.step();
    const double now = seconds(CLOCK_PROCESS_CPUTIME_ID);
    const double time = result.reached = simulation.time();
    result.cpu = now - start - judging;
    const auto fail = [&](const Failure& found) {
      const bool is_limited = found.kind == Failure::Kind::cpu_limit;
      const Outcome outcome = is_limited ? Outcome::limited : Outcome::failed;
      end_with(is_clear(found.text) ? outcome : Outcome::unclear, found.text);
    };
    if (failure && failure->kind != Failure::Kind::energy) return fail(*failure);
    if (!all_finite(simulation.state()) || !std::isfinite(time))
      return end_with(Outcome::not_finite, "a value is not finite at t = " + number_text(time));
    if (failure) return fail(*failure);
    if (time < options.duration && limit.is_passed()) return fail(limit.failure(simulation));
    if (time < next_look && time < options.duration) continue;
    if (auto fault = judge.check(time, simulation.state())) return end_with(Outcome::wrong, *fault);
    next_look = time + options.duration / looks;
    const double judged = seconds(CLOCK_PROCESS_CPUTIME_ID) - now;
    judging += judged;
    limit.exclude(judged);
  }
  if (traits_of(options.method).finds_equilibria()) {
    if (auto fault = judge.check_rest(options.duration, simulation.state()))
      return end_with(Outcome::wrong, *fault);
    return end_with(Outcome::finished, "");
  }
  std::vector<double> last(simulation.state().size());
  static_cast<void>(simulation.state_at(options.duration, last));
  const std::string reason =
      inexactness(scene, judge, converged, tolerance, options.duration, last, result);
  end_with(reason.empty() ? Outcome::finished : Outcome::inexact, reason);
}

CellResult run_here(const std::string& path, const std::vector<std::string>& overrides,
                    const ConvergedEnd* converged, double tolerance) {
  CellResult result;
  try {
    Simulation simulation = make_simulation(read_case(path, overrides));
    Judge judge(simulation.scene());
    advance(simulation, judge, converged, tolerance, result);
    result.steps = simulation.counts().steps;
    result.energy = judge.largest_share();
  } catch (const CaseError& error) {
    result.outcome = *error.what() == 0 ? Outcome::unclear : Outcome::refused;
    result.message = error.what();
  }
  return result;
}

std::string text_of(const CellResult& result) {
  return nlohmann::json{static_cast<int>(result.outcome),
                        result.message,
                        result.cpu,
                        result.reached,
                        result.energy,
                        result.steps,
                        result.error,
                        result.lost}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// Returns a number; one that was not finite arrives as null.
double number_of(const nlohmann::json& value) {
  return value.is_number() ? value.get<double>() : std::nan("");
}

CellResult result_of(const std::string& text) {
  const auto json = nlohmann::json::parse(text);
  CellResult result;
  result.outcome = static_cast<Outcome>(json[0].get<int>());
  result.message = json[1].get<std::string>();
  result.cpu = number_of(json[2]);
  result.reached = number_of(json[3]);
  result.energy = number_of(json[4]);
  result.steps = json[5].get<std::int64_t>();
  result.error = number_of(json[6]);
  result.lost = number_of(json[7]);
  return result;
}

CellResult result_of(const ChildEnd& end, double hang) {
  if (end.is_well) return result_of(end.result);
  CellResult result;
  if (end.signal == SIGXCPU || end.signal == SIGKILL) {
    result.outcome = Outcome::hung;
    result.cpu = hang;
    result.message = "a step did not end";
  } else {
    result.message = end.signal != 0 ? strsignal(end.signal) : "the process ended";
  }
  return result;
}

}  // namespace

const char* outcome_name(Outcome outcome) { return names[static_cast<int>(outcome)]; }

std::vector<CellResult> run_cells(std::span<const Cell> cells, const ConvergedEnds& converged,
                                  double limit, int jobs,
                                  const std::function<void(const Cell&, const CellResult&)>& done) {
  std::vector<CellResult> results(cells.size());
  const auto hang = [&](std::size_t i) {
    return least_patience + patience * limit * cells[i].size;
  };
  run_children(
      cells.size(), jobs, hang,
      [&](std::size_t i) {
        std::vector<std::string> overrides = cells[i].overrides;
        overrides.push_back("compute.cpu_limit=" + number_text(limit * cells[i].size));
        return text_of(run_here(WEFT_SOURCE_DIR "/" + cells[i].path, overrides,
                                converged.at_end_of(cells[i]), cells[i].tolerance));
      },
      [&](std::size_t i, const ChildEnd& end) {
        results[i] = result_of(end, hang(i));
        done(cells[i], results[i]);
      });
  return results;
}

}  // namespace weft::bench
