#include "sim/sweep/sweep_monitor.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <utility>

#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

// Shortest time (s) between two drawings of the table, and between two summaries. A summary comes
// later if writing it takes more than a twentieth of that time.
constexpr double redrawn_after = 0.25, summary_after = 1, summary_share = 20;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string clock_text(double seconds) {
  const long whole = std::lround(seconds);
  char text[48];
  if (whole < 3600) {
    std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  } else {
    std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
  }
  return text;
}

// Returns the percentage that weft run printed last into its log, or nothing.
std::optional<double> percentage_in(const std::filesystem::path& log) {
  std::ifstream file(log, std::ios::binary | std::ios::ate);
  if (!file) return std::nullopt;
  constexpr std::streamoff most = 400;
  file.seekg(std::max<std::streamoff>(0, file.tellg() - most));
  std::optional<double> last;
  for (std::string line; std::getline(file, line);) {
    double percentage = 0;
    char sign = 0;
    if (std::sscanf(line.c_str(), "%lf %c", &percentage, &sign) == 2 && sign == '%')
      last = percentage;
  }
  return last;
}

std::size_t terminal_columns() {
  winsize size{};
  const bool is_known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return is_known ? size.ws_col - 1 : 79;
}

bool has_ended(const RunRecord& record) {
  return record.state == RunState::done || record.state == RunState::failed;
}

}  // namespace

SweepMonitor::SweepMonitor(std::filesystem::path directory, const SweepPlan& plan,
                           std::vector<RunRecord>& records, OutputCollector& collector,
                           const Options& options)
    : directory_(std::move(directory)),
      plan_(plan),
      records_(records),
      collector_(collector),
      options_(options),
      terminal_(isatty(STDERR_FILENO) != 0) {
  to_do_ = static_cast<int>(records.size() - std::ranges::count_if(records, has_ended));
  for (std::size_t i = 0; i < plan.runs.size(); ++i) runs_of_hash_.emplace(plan.runs[i].hash, i);
}

SweepMonitor::~SweepMonitor() { erase_table(); }

void SweepMonitor::begun(std::size_t index, int attempt, const std::filesystem::path& log) {
  if (attempt > 1) print(index, "attempt " + std::to_string(attempt));
  if (has_ended(records_[index])) ++to_do_;  // a failed run that runs again
  records_[index] = {RunState::running, {}};
  std::erase_if(shown_, [&](const Shown& run) { return run.index == index; });
  shown_.push_back({index, log, Clock::now()});
}

void SweepMonitor::ended(std::size_t index, const RunResult& result) {
  const RunState state = result.is_done() ? RunState::done : RunState::failed;
  const auto [first, last] = runs_of_hash_.equal_range(plan_.runs[index].hash);
  for (auto same = first; same != last; ++same) {
    RunRecord& record = records_[same->second];
    if (!has_ended(record)) --to_do_;
    record = {state, result};
  }
  std::erase_if(shown_, [&](const Shown& run) { return run.index == index; });
  collector_.forget(plan_.runs[index].hash);
  ++ended_here_;
  seconds_here_ += result.wall_seconds;
  print(index, std::string(state_name(state)) + " in " +
                   rounded_text(std::round(result.wall_seconds * 100) / 100) + " s" +
                   (result.reason.empty() ? "" : ": " + in_one_line(result.reason)));
  is_summary_old_ = true;
  refresh_summary();
}

void SweepMonitor::refresh_summary() {
  if (!options_.writes_summary || !is_summary_old_ || Clock::now() < next_summary_) return;
  const Clock::time_point start = Clock::now();
  write_summary(directory_, plan_, records_, collector_);
  is_summary_old_ = false;
  const double pause = std::max(summary_after, summary_share * seconds_since(start));
  next_summary_ = Clock::now() +
                  std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(pause));
}

void SweepMonitor::begins_anew(std::size_t index, const std::string& reason) {
  print(index, "begins anew, since it cannot go on from its checkpoint: " + reason);
}

void SweepMonitor::left_out(std::size_t index, const std::string& reason) {
  RunRecord& record = records_[index];
  if (!has_ended(record))
    record = {RunFolder(directory_, plan_.runs[index].hash).state_without_result(), {}};
  std::erase_if(shown_, [&](const Shown& run) { return run.index == index; });
  print(index, std::string(state_name(record.state)) + ": " + reason);
}

void SweepMonitor::interrupted(std::size_t index) {
  records_[index] = {RunState::interrupted, {}};
  std::erase_if(shown_, [&](const Shown& run) { return run.index == index; });
  print(index, "interrupted");
}

void SweepMonitor::held_by_another(std::size_t index) {
  records_[index] = {RunState::running, {}};
  std::erase_if(shown_, [&](const Shown& run) { return run.index == index; });
  print(index, "another worker is at it");
}

void SweepMonitor::idle() {
  refresh_summary();
  if (options_.quiet || !terminal_ || seconds_since(last_drawn_) < redrawn_after) return;
  erase_table();
  draw_table();
}

void SweepMonitor::print(std::size_t index, const std::string& text) {
  if (options_.quiet) return;
  erase_table();
  const PlannedRun& run = plan_.runs[index];
  const std::string line = "[" + std::to_string(index + 1) + '/' +
                           std::to_string(plan_.runs.size()) + "] " + run.hash.substr(0, 16) +
                           " (" + values_text(plan_, run) + ") " + text;
  std::fprintf(stderr, "%s\n", printable(line).c_str());
}

void SweepMonitor::erase_table() {
  if (lines_drawn_ > 0) std::fprintf(stderr, "\033[%dA\033[J", lines_drawn_);
  lines_drawn_ = 0;
}

void SweepMonitor::draw_table() {
  last_drawn_ = Clock::now();
  const std::size_t width = terminal_columns();
  const std::string head = counts_text(count_records(records_)) + ", remaining " + remaining_text();
  std::fprintf(stderr, "%s\n", head.substr(0, width).c_str());
  for (const Shown& run : shown_)
    std::fprintf(stderr, "%s\n", printable(line_of(run)).substr(0, width).c_str());
  std::fflush(stderr);
  lines_drawn_ = 1 + static_cast<int>(shown_.size());
}

std::string SweepMonitor::line_of(const Shown& run) const {
  const double elapsed = seconds_since(run.start);
  const std::optional<double> percentage = percentage_in(run.log);
  std::string progress = "  0 %";
  std::string remaining = "unknown";
  if (percentage && *percentage > 0) {
    char text[32];
    std::snprintf(text, sizeof text, "%3.0f %%", *percentage);
    progress = text;
    remaining = clock_text(std::max(0.0, elapsed * (100 / *percentage - 1)));
  }
  const PlannedRun& planned = plan_.runs[run.index];
  return "  [" + std::to_string(run.index + 1) + "] " + progress + "  " + clock_text(elapsed) +
         ", remaining " + remaining + "  " + values_text(plan_, planned);
}

// The mean time of the runs so far, for all runs to do, on all processes. Half of each run that
// goes on is taken as done.
std::string SweepMonitor::remaining_text() const {
  if (ended_here_ == 0) return "unknown";
  const double runs = to_do_ - 0.5 * static_cast<double>(shown_.size());
  return clock_text(runs * seconds_here_ / ended_here_ / options_.processes);
}

}  // namespace weft::sim
