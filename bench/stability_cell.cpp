#include "bench/stability_cell.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/medians.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/simulation.h"

namespace weft::bench {

namespace {

using namespace sim;

constexpr int looks = 25;             // at states of a run, before the last
constexpr double patience = 3;        // budgets after which a step that does not end is a hang
constexpr double least_patience = 2;  // s

constexpr const char* names[outcome_count] = {"finished", "refused", "failed",
                                              "too slow", "hung",    "not finite",
                                              "wrong",    "unclear", "crashed"};

// Steps to the end of the case, a failure, or the end of the budget.
void advance(Dynamics& dynamics, Integrator& integrator, Judge& judge, double budget,
             CellResult& result) {
  const double start = seconds(CLOCK_PROCESS_CPUTIME_ID);
  const TimeCase& options = dynamics.scene().source.time;
  EnergyWatch watch(dynamics.scene(), dynamics.energies(0, integrator.state()));
  double next_look = 0, judging = 0;
  const auto end_with = [&](Outcome outcome, std::string message) {
    result.outcome = outcome;
    result.message = std::move(message);
  };
  while (integrator.time() < options.duration * (1 - 1e-9)) {
    const auto failure = integrator.step();
    const double now = seconds(CLOCK_PROCESS_CPUTIME_ID);
    const double time = result.reached = integrator.time();
    result.cpu = now - start - judging;
    // A failure that took so long comes too late.
    if (result.cpu > budget)
      return end_with(Outcome::too_slow, "the budget of " + number_text(budget) +
                                             " s is spent at t = " + number_text(time) + " s");
    if (failure) return end_with(is_clear(*failure) ? Outcome::failed : Outcome::unclear, *failure);
    if (!all_finite(integrator.state()) || !std::isfinite(time))
      return end_with(Outcome::not_finite, "a value is not finite at t = " + number_text(time));
    const Energies energies = dynamics.energies_at_last_rate(time, integrator.state());
    if (auto fault = watch.check(time, integrator.state(), energies))
      return end_with(is_clear(*fault) ? Outcome::failed : Outcome::unclear, *fault);
    if (time < next_look && time < options.duration) continue;
    if (auto fault = judge.check(time, integrator.state())) return end_with(Outcome::wrong, *fault);
    next_look = time + options.duration / looks;
    judging += seconds(CLOCK_PROCESS_CPUTIME_ID) - now;
  }
  if (options.method == TimeMethod::static_loads) {
    if (auto fault = judge.check_rest(options.duration, integrator.state()))
      return end_with(Outcome::wrong, *fault);
  }
  result.outcome = Outcome::finished;
}

CellResult run_here(const std::string& path, const std::vector<std::string>& overrides,
                    double budget) {
  CellResult result;
  try {
    const auto scene = build_scene(read_case(path, overrides));
    check_initial_state(*scene);
    Statistics statistics;
    Dynamics dynamics(*scene, statistics);
    const auto integrator = make_integrator(*scene, dynamics);
    Judge judge(*scene);
    advance(dynamics, *integrator, judge, budget, result);
    result.steps = integrator->counts().steps;
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
                        result.steps}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// A number that was not finite comes as null.
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
  return result;
}

[[noreturn]] void be_the_child(int pipe_end, const std::string& path,
                               const std::vector<std::string>& overrides, double budget) {
  const auto limit = static_cast<rlim_t>(std::ceil(least_patience + patience * budget));
  const rlimit cpu{limit, limit + 1};
  setrlimit(RLIMIT_CPU, &cpu);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const std::string text = text_of(run_here(path, overrides, budget));
  const bool written =
      write(pipe_end, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  _exit(written ? 0 : 1);
}

std::string read_all(int descriptor) {
  std::string text;
  char buffer[4096];
  for (ssize_t count; (count = read(descriptor, buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(count));
  return text;
}

struct Child {
  pid_t process = 0;
  int pipe_end = 0;
  std::size_t cell = 0;
  double budget = 0;
};

Child start(const Cell& cell, double budget, std::size_t index) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  std::fflush(nullptr);
  const pid_t process = fork();
  if (process < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
  if (process == 0) be_the_child(ends[1], WEFT_SOURCE_DIR "/" + cell.path, cell.overrides, budget);
  close(ends[1]);
  return {process, ends[0], index, budget};
}

// Of a child that has ended.
CellResult collect(const Child& child, int status) {
  const std::string text = read_all(child.pipe_end);
  close(child.pipe_end);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return result_of(text);
  CellResult result;
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    result.outcome = Outcome::hung;
    result.cpu = least_patience + patience * child.budget;
    result.message = "a step did not end";
  } else {
    result.message = WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "the process ended";
  }
  return result;
}

}  // namespace

const char* outcome_name(Outcome outcome) { return names[static_cast<int>(outcome)]; }

std::vector<CellResult> run_cells(std::span<const Cell> cells, double budget, int jobs,
                                  const std::function<void(const Cell&, const CellResult&)>& done) {
  std::vector<CellResult> results(cells.size());
  std::map<pid_t, Child> running;
  for (std::size_t next = 0; next < cells.size() || !running.empty();) {
    if (next < cells.size() && running.size() < static_cast<std::size_t>(jobs)) {
      const Child child = start(cells[next], budget * cells[next].size, next);
      running[child.process] = child;
      ++next;
      continue;
    }
    int status = 0;
    const pid_t ended = waitpid(-1, &status, 0);
    if (ended < 0) throw std::runtime_error(std::string("waitpid: ") + std::strerror(errno));
    const Child child = running.at(ended);
    running.erase(ended);
    results[child.cell] = collect(child, status);
    done(cells[child.cell], results[child.cell]);
  }
  return results;
}

}  // namespace weft::bench
