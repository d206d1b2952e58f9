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
#include "sim/cpu_limit.h"
#include "sim/simulation.h"

namespace weft::bench {

namespace {

using namespace sim;

constexpr int looks = 25;              // at states of a run, before the last
constexpr double patience = 3;         // limits after which a step that does not end is a hang
constexpr double least_patience = 10;  // s

constexpr const char* names[outcome_count] = {"finished", "refused", "failed",     "limited",
                                              "too slow", "hung",    "not finite", "wrong",
                                              "unclear",  "crashed"};

// Steps to the end of the case, a failure, or its limit.
void advance(Dynamics& dynamics, Integrator& integrator, Judge& judge, CellResult& result) {
  const double start = seconds(CLOCK_PROCESS_CPUTIME_ID);
  const TimeCase& options = dynamics.scene().source.time;
  CpuLimit limit(dynamics.scene().source.compute.cpu_limit.value());
  bool is_limited = false;
  integrator.set_reason_to_stop([&]() -> std::optional<std::string> {
    is_limited = limit.is_passed();
    if (!is_limited) return std::nullopt;
    return limit.reason(dynamics.scene(), integrator);
  });
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
    const auto fail = [&](const std::string& reason, Outcome outcome) {
      end_with(is_clear(reason) ? outcome : Outcome::unclear, reason);
    };
    if (failure) return fail(*failure, is_limited ? Outcome::limited : Outcome::failed);
    if (!all_finite(integrator.state()) || !std::isfinite(time))
      return end_with(Outcome::not_finite, "a value is not finite at t = " + number_text(time));
    const Energies energies = dynamics.energies_at_last_rate(time, integrator.state());
    if (auto fault = watch.check(time, integrator.state(), energies))
      return fail(*fault, Outcome::failed);
    if (time < options.duration && limit.is_passed())
      return fail(limit.reason(dynamics.scene(), integrator), Outcome::limited);
    if (time < next_look && time < options.duration) continue;
    if (auto fault = judge.check(time, integrator.state())) return end_with(Outcome::wrong, *fault);
    next_look = time + options.duration / looks;
    const double judged = seconds(CLOCK_PROCESS_CPUTIME_ID) - now;
    judging += judged;
    limit.exclude(judged);
  }
  if (options.method == TimeMethod::static_loads) {
    if (auto fault = judge.check_rest(options.duration, integrator.state()))
      return end_with(Outcome::wrong, *fault);
  }
  result.outcome = Outcome::finished;
}

CellResult run_here(const std::string& path, const std::vector<std::string>& overrides) {
  CellResult result;
  try {
    const auto scene = build_scene(read_case(path, overrides));
    check_initial_state(*scene);
    Statistics statistics;
    Dynamics dynamics(*scene, statistics);
    const auto integrator = make_integrator(*scene, dynamics);
    Judge judge(*scene);
    advance(dynamics, *integrator, judge, result);
    integrator->set_reason_to_stop({});
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

[[noreturn]] void be_the_child(int pipe_end, const Cell& cell, double limit) {
  const auto hang = static_cast<rlim_t>(std::ceil(least_patience + patience * limit));
  const rlimit cpu{hang, hang + 1};
  setrlimit(RLIMIT_CPU, &cpu);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  std::vector<std::string> overrides = cell.overrides;
  overrides.push_back("compute.cpu_limit=" + number_text(limit));
  const std::string text = text_of(run_here(WEFT_SOURCE_DIR "/" + cell.path, overrides));
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
  double limit = 0;  // s of CPU time
};

Child start(const Cell& cell, double limit, std::size_t index) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  std::fflush(nullptr);
  const pid_t process = fork();
  if (process < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
  if (process == 0) be_the_child(ends[1], cell, limit);
  close(ends[1]);
  return {process, ends[0], index, limit};
}

// Of a child that has ended.
CellResult collect(const Child& child, int status) {
  const std::string text = read_all(child.pipe_end);
  close(child.pipe_end);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return result_of(text);
  CellResult result;
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    result.outcome = Outcome::hung;
    result.cpu = least_patience + patience * child.limit;
    result.message = "a step did not end";
  } else {
    result.message = WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "the process ended";
  }
  return result;
}

}  // namespace

const char* outcome_name(Outcome outcome) { return names[static_cast<int>(outcome)]; }

std::vector<CellResult> run_cells(std::span<const Cell> cells, double limit, int jobs,
                                  const std::function<void(const Cell&, const CellResult&)>& done) {
  std::vector<CellResult> results(cells.size());
  std::map<pid_t, Child> running;
  for (std::size_t next = 0; next < cells.size() || !running.empty();) {
    if (next < cells.size() && running.size() < static_cast<std::size_t>(jobs)) {
      const Child child = start(cells[next], limit * cells[next].size, next);
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
