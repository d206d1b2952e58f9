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

#include "sim/base/file_error.h"
#include "sim/case/case_text.h"
#include "sim/sweep/child_process.h"
#include "sim/sweep/run_identity.h"
#include "sim/sweep/sweep_outputs.h"
#include "sim/sweep/whole_file.h"

namespace weft::sim {

namespace {

using Clock = std::chrono::steady_clock;
using Failure = RunResult::Failure;

// Times (s): between two looks at the runs, and from SIGTERM to SIGKILL for a run over its time.
constexpr double look_interval = 0.05, patience = 5;
// Time between two looks at runs that other workers hold.
constexpr std::chrono::milliseconds held_interval(500);

// Blocks signals while it lives, so that wait() receives them.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigemptyset(&set_);
    for (const int signal : {SIGCHLD, SIGINT, SIGTERM, SIGUSR1}) sigaddset(&set_, signal);
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

// A run that is to begin.
struct Waiting {
  RunToDo run;
  int number = 1;        // of the attempt
  bool anew = false;     // without the files of an earlier attempt
  bool is_own = true;    // of EngineOptions::runs
  bool is_told = false;  // the observer knows that another worker is at it
};

struct Active {
  Waiting start;
  RunAttempt attempt;
  ChildProcess process;
  Exceeded exceeded = Exceeded::nothing;
  double peak_seen = 0;                           // MiB
  std::optional<Clock::time_point> to_kill = {};  // time at which SIGKILL follows SIGTERM
};

// Returns `reason` of the JSON object that weft run printed, or an empty text. Files of the attempt
// are named as they are once the run has ended, when they lie in the folder of the run.
std::string reason_in(const std::string& report, const std::filesystem::path& attempt) {
  const auto json = nlohmann::json::parse(report, nullptr, false);
  if (!json.is_object() || !json.contains("reason") || !json["reason"].is_string()) return "";
  auto reason = json["reason"].get<std::string>();
  const std::string during = attempt.string(), after = attempt.parent_path().string();
  for (auto at = reason.find(during); at != std::string::npos; at = reason.find(during, at))
    reason.replace(at, during.size(), after);
  return reason;
}

// Returns a number of the report that weft run printed, or nothing.
std::optional<double> number_in(const std::string& report, const char* key) {
  const auto json = nlohmann::json::parse(report, nullptr, false);
  const auto number = json.is_object() ? json.find(key) : json.end();
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
      : directory_(directory),
        plan_(plan),
        options_(options),
        observer_(observer),
        schedule_(options.end, Clock::now()),
        inputs_(plan.digests) {
    for (const RunToDo& run : options.runs) waiting_.push_back({.run = run});
    for (const RunToDo& run : options.others) others_.push_back({.run = run, .is_own = false});
  }

  EngineReport compute() {
    const Clock::time_point start = Clock::now();
    while (true) {
      follow_schedule();
      if (!stopping()) start_waiting();
      if (active_.empty() && (stopping() || held_.empty())) break;
      take_signal(signals_.wait(look_interval));
      for (Active& each : active_) watch(each);
      collect();
      observer_.idle();
    }
    report_.wall_seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return report_;
  }

 private:
  RunFolder folder(std::size_t index) const { return {directory_, plan_.runs[index].hash}; }
  bool stopping() const {
    return report_.stop_signal != 0 || has_failed_fast_ || report_.ran_out_of_time;
  }

  void start_waiting() {
    while (active_.size() < static_cast<std::size_t>(options_.processes)) {
      std::optional<Waiting> next = next_run();
      if (!next) return;
      start(std::move(*next));
    }
  }

  std::optional<Waiting> next_run() {
    if (waiting_.empty() && Clock::now() >= next_look_at_held_) {
      waiting_.swap(held_);
      next_look_at_held_ = Clock::now() + held_interval;
    }
    std::deque<Waiting>& from = waiting_.empty() ? others_ : waiting_;
    if (from.empty()) return std::nullopt;
    Waiting next = std::move(from.front());
    from.pop_front();
    return next;
  }

  void start(Waiting next) {
    const std::size_t index = next.run.index;
    const PlannedRun& run = plan_.runs[index];
    const std::string& replaced = next.run.failed_result;
    const auto is_ended = [&] {
      return folder(index).result() && folder(index).result_mark() != replaced;
    };
    if (is_ended()) return;
    const InputCheck::Finding input = inputs_.look_at(run.inputs);
    if (input.state != InputCheck::State::as_planned) return leave_out(index, input.reason);
    std::optional<RunAttempt> attempt =
        folder(index).begin(run.case_text, {.replaced = replaced, .anew = next.anew});
    if (!attempt) {
      if (next.is_own && !is_ended()) hold(std::move(next));
      return;
    }
    const std::filesystem::path& place = attempt->folder();
    ChildProcess::Command command;
    command.words = {options_.program, "run",   (place / "run.toml").string(), "-o", place.string(),
                     "--resume",       "--json"};
    if (plan_.estimate_error) command.words.emplace_back("--estimate-error");
    command.output = place / "report.json";
    command.errors = place / "log.txt";
    command.threads = options_.threads;
    command.inherited = attempt->lock_descriptor();
    observer_.begun(index, next.number, command.errors);
    active_.push_back({std::move(next), std::move(*attempt), ChildProcess(command)});
  }

  // Leaves the run without a result.
  void leave_out(std::size_t index, const std::string& reason) {
    report_.input_faults.insert(reason);
    observer_.left_out(index, reason);
  }

  // Looks at the run again later.
  void hold(Waiting next) {
    if (!next.is_told) observer_.held_by_another(next.run.index);
    next.is_told = true;
    held_.push_back(std::move(next));
  }

  void follow_schedule() {
    const StopSchedule::Phase phase = schedule_.phase(Clock::now());
    if (phase == phase_) return;
    phase_ = phase;
    report_.ran_out_of_time = true;
    stop_all(phase == StopSchedule::Phase::stopping ? SIGTERM : SIGUSR1);
  }

  void take_signal(int signal) {
    if (signal == SIGUSR1) schedule_.heed_notice(Clock::now());
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

  // True if the run did not end by itself, and can go on later.
  bool was_stopped(const Active& ended, const ChildEnd& end) const {
    if (ended.exceeded != Exceeded::nothing) return false;
    const bool by_code = end.exit_code == 128 + SIGTERM || end.exit_code == 128 + SIGINT;
    const bool by_signal = end.signal == SIGTERM || end.signal == SIGINT || end.signal == SIGUSR1;
    return by_code || by_signal || (stopping() && end.signal == SIGKILL);
  }

  void settle(Active ended, const ChildEnd& end) {
    const std::size_t index = ended.start.run.index;
    const InputCheck::Finding input = inputs_.look_at(plan_.runs[index].inputs);
    if (input.state == InputCheck::State::changed) {
      // The attempt may have read the file as it was or as it is.
      folder(index).discard(std::move(ended.attempt));
      return leave_out(index, input.reason);
    }
    if (was_stopped(ended, end)) return observer_.interrupted(index);
    if (input.state == InputCheck::State::unreadable) return leave_out(index, input.reason);
    const RunResult result = result_of(ended, end);
    Waiting again = ended.start;
    const std::string fault = stopping() ? "" : fault_of_checkpoint(ended, result);
    if (!fault.empty()) {
      again.anew = true;
      observer_.begins_anew(index, fault);
      return waiting_.push_front(std::move(again));
    }
    if (may_pass(result.failure) && again.number <= options_.retries && !stopping()) {
      again.anew = false;
      ++again.number;
      return waiting_.push_front(std::move(again));
    }
    if (!folder(index).finish(std::move(ended.attempt), result))
      return observer_.held_by_another(index);
    observer_.ended(index, result);
    if (options_.fail_fast && !result.is_done() && !has_failed_fast_) {
      has_failed_fast_ = true;
      stop_all(SIGTERM);
    }
  }

  // Returns the reason why the run cannot go on from the checkpoint with which it began, or an
  // empty text. A full disk, for example, is none: the next attempt may have room.
  std::string fault_of_checkpoint(const Active& ended, const RunResult& result) const {
    const bool was_refused =
        result.failure == Failure::bad_case || result.failure == Failure::input_output;
    if (!ended.attempt.resumes() || !was_refused) return "";
    // The state in a checkpoint is read by the simulation alone.
    if (result.reason.find("run.checkpoint: cannot be continued: ") != std::string::npos)
      return result.reason;
    return ended.attempt.fault_of_checkpoint(plan_.runs[ended.start.run.index].case_text,
                                             plan_.estimate_error);
  }

  RunResult result_of(const Active& ended, const ChildEnd& end) const {
    RunResult result;
    result.hash = plan_.runs[ended.start.run.index].hash;
    result.exit_code = end.exit_code;
    result.signal = end.signal;
    result.attempts = ended.start.number;
    result.version = WEFT_VERSION;
    result.report = read_whole_file(ended.attempt.folder() / "report.json").value_or("");
    // The system counts the memory of this process, from which the run was started, as the run's
    // too, and only this attempt's time. The report of a run that went on has the time of all.
    result.peak_memory = number_in(result.report, "peak_memory_mib").value_or(end.peak_memory);
    result.wall_seconds = number_in(result.report, "wall_s").value_or(end.wall_seconds);
    result.cpu_seconds = number_in(result.report, "cpu_s").value_or(end.cpu_seconds);
    result.outputs = output_values(ended.attempt.folder() / "run.h5", outputs_);
    explain(result, ended, exceeded_by(ended, end, result));
    return result;
  }

  // Returns the limit that the run exceeded. A run that is done may have done so between two looks.
  Exceeded exceeded_by(const Active& ended, const ChildEnd& end, const RunResult& result) const {
    const LimitsCase& limits = plan_.limits;
    if (ended.exceeded != Exceeded::nothing || end.signal != 0 || end.exit_code != 0)
      return ended.exceeded;
    if (limits.memory && result.peak_memory > *limits.memory) return Exceeded::memory;
    if (limits.time && end.wall_seconds > *limits.time) return Exceeded::time;
    return Exceeded::nothing;
  }

  // Sets the kind and the reason of a failure.
  void explain(RunResult& result, const Active& ended, Exceeded exceeded) const {
    if (exceeded == Exceeded::memory) {
      const bool was_ended = ended.exceeded == Exceeded::memory;
      const double taken = was_ended ? ended.peak_seen : result.peak_memory;
      result.failure = Failure::over_memory;
      result.reason =
          "took " + rounded_text(std::ceil(10 * taken) / 10) +
          " MiB of memory, more than limits.memory = " + rounded_text(*plan_.limits.memory) +
          " MiB";
    } else if (exceeded == Exceeded::time) {
      result.failure = Failure::over_time;
      result.reason = "took longer than limits.time = " + rounded_text(*plan_.limits.time) + " s";
    } else if (result.signal != 0) {
      result.failure = Failure::signal;
      result.reason = "ended by signal " + std::to_string(result.signal) + " (" +
                      strsignal(result.signal) + ")";
    } else if (result.exit_code != 0) {
      result.failure = failure_of_code(result.exit_code);
      result.reason = reason_in(result.report, ended.attempt.folder());
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
  StopSchedule schedule_;
  InputCheck inputs_;
  StopSchedule::Phase phase_ = StopSchedule::Phase::running;
  // Own runs, own runs that another worker is at, and runs of others.
  std::deque<Waiting> waiting_, held_, others_;
  Clock::time_point next_look_at_held_;
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
