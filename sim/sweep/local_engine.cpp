#include "sim/sweep/local_engine.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <deque>
#include <list>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "sim/base/file_error.h"
#include "sim/case/case_text.h"
#include "sim/sweep/child_process.h"
#include "sim/sweep/sweep_outputs.h"
#include "sim/sweep/whole_file.h"

namespace weft::sim {

namespace {

using Clock = std::chrono::steady_clock;
using Failure = RunResult::Failure;

// Times (s): between two looks at the runs, and from SIGTERM to SIGKILL for a run over its time.
constexpr double look_interval = 0.05, patience = 5;

// Blocks signals while it lives, so that wait() receives them.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigemptyset(&set_);
    for (const int signal : {SIGCHLD, SIGINT, SIGTERM}) sigaddset(&set_, signal);
    sigprocmask(SIG_BLOCK, &set_, &before_);
  }
  ~BlockedSignals() { sigprocmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

  // Waits for a signal. Returns it, or 0 after `seconds` or another interruption.
  int wait(double seconds) const {
    const timespec limit{0, static_cast<long>(1e9 * seconds)};
    return std::max(0, sigtimedwait(&set_, nullptr, &limit));
  }

 private:
  sigset_t set_{}, before_{};
};

// The limit that a run exceeded.
enum class Exceeded { nothing, time, memory };

struct Active {
  std::size_t index;
  int number;  // of the attempt, from 1
  RunAttempt attempt;
  ChildProcess process;
  Exceeded exceeded = Exceeded::nothing;
  double peak_seen = 0;                           // MiB
  std::optional<Clock::time_point> to_kill = {};  // time at which SIGKILL follows SIGTERM
};

// Returns `reason` of the JSON object that weft run printed, or an empty text.
std::string reason_in(const std::string& report) {
  const auto json = nlohmann::json::parse(report, nullptr, false);
  if (!json.is_object() || !json.contains("reason") || !json["reason"].is_string()) return "";
  return json["reason"].get<std::string>();
}

// Returns the peak memory (MiB) that weft run printed, or nothing. The system counts the memory of
// this process, from which the run was started, as the run's too.
std::optional<double> peak_memory_in(const std::string& report) {
  const auto json = nlohmann::json::parse(report, nullptr, false);
  const auto number = json.is_object() ? json.find("peak_memory_mib") : json.end();
  return number != json.end() && number->is_number() ? std::optional(number->get<double>())
                                                     : std::nullopt;
}

Failure failure_of_code(int code) {
  switch (code) {
    case 0:
      return Failure::none;
    case 1:
      return Failure::numerical;
    case 2:
      return Failure::bad_case;
    default:
      return Failure::input_output;
  }
}

// True for a failure that another attempt may not have.
bool may_pass(Failure failure) {
  return failure == Failure::signal || failure == Failure::input_output;
}

class LocalEngine {
 public:
  LocalEngine(const std::filesystem::path& directory, const SweepPlan& plan,
              const EngineOptions& options, EngineObserver& observer)
      : directory_(directory), plan_(plan), options_(options), observer_(observer) {
    std::set<std::string> seen;
    for (const std::size_t index : options.runs) {
      const PlannedRun& run = plan.runs[index];
      if (!run.refusal.empty() || !seen.insert(run.hash).second) continue;
      const auto result = folder(index).result();
      if (!result || (options.rerun_failed && !result->is_done()))
        waiting_.push_back({index, 1, result.has_value()});
    }
  }

  EngineReport compute() {
    const Clock::time_point start = Clock::now();
    while (true) {
      if (!stopping()) start_waiting();
      if (active_.empty()) break;
      take_signal(signals_.wait(look_interval));
      for (Active& each : active_) watch(each);
      collect();
      observer_.idle();
    }
    report_.wall_seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return report_;
  }

 private:
  struct Waiting {
    std::size_t index;
    int number;  // of the attempt, from 1
    bool had_failed = false;
    bool anew = false;  // without the files of an earlier attempt
  };

  RunFolder folder(std::size_t index) const { return {directory_, plan_.runs[index].hash}; }
  bool stopping() const { return report_.stop_signal != 0 || has_failed_fast_; }

  void start_waiting() {
    while (!waiting_.empty() && active_.size() < static_cast<std::size_t>(options_.processes)) {
      const Waiting next = waiting_.front();
      waiting_.pop_front();
      start(next);
    }
  }

  void start(const Waiting& next) {
    const PlannedRun& run = plan_.runs[next.index];
    // Another worker may have ended the run meanwhile.
    const auto result = folder(next.index).result();
    if (result && (result->is_done() || !next.had_failed)) return;
    std::optional<RunAttempt> attempt = folder(next.index).begin(run.case_text, next.anew);
    if (!attempt) return observer_.left_to_another(next.index);
    const std::filesystem::path& place = attempt->folder();
    ChildProcess::Command command;
    command.words = {options_.program, "run",   (place / "run.toml").string(), "-o", place.string(),
                     "--resume",       "--json"};
    if (plan_.estimate_error) command.words.emplace_back("--estimate-error");
    command.output = place / "report.json";
    command.errors = place / "log.txt";
    command.threads = options_.threads;
    command.inherited = attempt->lock_descriptor();
    observer_.begun(next.index, next.number, command.errors);
    active_.push_back({next.index, next.number, std::move(*attempt), ChildProcess(command)});
  }

  void take_signal(int signal) {
    if (signal != SIGINT && signal != SIGTERM) return;
    const bool again = report_.stop_signal != 0;
    if (!again) report_.stop_signal = signal;
    stop_all(again ? SIGKILL : SIGTERM);
  }
  void stop_all(int signal) const {
    for (const Active& each : active_) each.process.send(signal);
  }

  // Ends a run that is beyond its limits.
  void watch(Active& each) const {
    const LimitsCase& limits = plan_.limits;
    if (each.to_kill && Clock::now() > *each.to_kill) each.process.send(SIGKILL);
    if (each.exceeded != Exceeded::nothing) return;
    if (limits.memory) {
      each.peak_seen = std::max(each.peak_seen, each.process.memory());
      if (each.peak_seen > *limits.memory) {
        each.exceeded = Exceeded::memory;
        return each.process.send(SIGKILL);
      }
    }
    if (limits.time && each.process.seconds() > *limits.time) {
      each.exceeded = Exceeded::time;
      each.process.send(SIGTERM);
      each.to_kill = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(patience));
    }
  }

  void collect() {
    for (auto each = active_.begin(); each != active_.end();) {
      const std::optional<ChildEnd> end = each->process.poll();
      if (!end) {
        ++each;
        continue;
      }
      report_.busy_seconds += end->wall_seconds;
      Active ended = std::move(*each);
      each = active_.erase(each);
      settle(std::move(ended), *end);
    }
  }

  void settle(Active ended, const ChildEnd& end) {
    const bool was_stopped =
        ended.exceeded == Exceeded::nothing &&
        (end.exit_code == 128 + SIGTERM || end.exit_code == 128 + SIGINT || end.signal == SIGTERM ||
         end.signal == SIGINT || (stopping() && end.signal == SIGKILL));
    if (was_stopped) return observer_.interrupted(ended.index);
    const RunResult result = result_of(ended, end);
    // A checkpoint of another build is refused, and one that is damaged cannot be read.
    const bool cannot_resume = ended.attempt.resumes() && (result.failure == Failure::bad_case ||
                                                           result.failure == Failure::input_output);
    if (cannot_resume && !stopping())
      return waiting_.push_front({ended.index, ended.number, true, true});
    const bool again = may_pass(result.failure) && ended.number <= options_.retries && !stopping();
    if (again) return waiting_.push_front({ended.index, ended.number + 1, true});
    const std::size_t index = ended.index;
    if (!folder(index).finish(std::move(ended.attempt), result))
      return observer_.left_to_another(index);
    observer_.ended(index, result);
    if (options_.fail_fast && !result.is_done() && !has_failed_fast_) {
      has_failed_fast_ = true;
      stop_all(SIGTERM);
    }
  }

  RunResult result_of(const Active& ended, const ChildEnd& end) const {
    RunResult result;
    result.hash = plan_.runs[ended.index].hash;
    result.exit_code = end.exit_code;
    result.signal = end.signal;
    result.attempts = ended.number;
    result.wall_seconds = end.wall_seconds;
    result.cpu_seconds = end.cpu_seconds;
    result.version = WEFT_VERSION;
    result.report = read_whole_file(ended.attempt.folder() / "report.json").value_or("");
    result.peak_memory = peak_memory_in(result.report).value_or(end.peak_memory);
    result.outputs = output_values(ended.attempt.folder() / "run.h5", outputs_);
    explain(result, ended);
    return result;
  }

  // Sets the kind and the reason of a failure.
  void explain(RunResult& result, const Active& ended) const {
    if (ended.exceeded == Exceeded::memory) {
      result.failure = Failure::over_memory;
      result.reason =
          "took " + rounded_text(std::round(ended.peak_seen)) +
          " MiB of memory, more than limits.memory = " + rounded_text(*plan_.limits.memory) +
          " MiB";
    } else if (ended.exceeded == Exceeded::time && (result.signal != 0 || result.exit_code != 0)) {
      result.failure = Failure::over_time;
      result.reason = "took longer than limits.time = " + rounded_text(*plan_.limits.time) + " s";
    } else if (result.signal != 0) {
      result.failure = Failure::signal;
      result.reason = "ended by signal " + std::to_string(result.signal) + " (" +
                      strsignal(result.signal) + ")";
    } else if (result.exit_code != 0) {
      result.failure = failure_of_code(result.exit_code);
      result.reason = reason_in(result.report);
      if (result.reason.empty())
        result.reason = "ended with exit code " + std::to_string(result.exit_code);
    }
  }

  const std::filesystem::path& directory_;
  const SweepPlan& plan_;
  const EngineOptions& options_;
  EngineObserver& observer_;
  const std::vector<OutputExpression> outputs_ =
      joined_outputs(plan_.case_outputs, plan_.sweep_outputs);
  BlockedSignals signals_;
  std::deque<Waiting> waiting_;
  std::list<Active> active_;
  EngineReport report_;
  bool has_failed_fast_ = false;
};

}  // namespace

EngineReport compute_runs(const std::filesystem::path& directory, const SweepPlan& plan,
                          const EngineOptions& options, EngineObserver& observer) {
  return LocalEngine(directory, plan, options, observer).compute();
}

int usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
  return std::max(1, CPU_COUNT(&set));
}

}  // namespace weft::sim
