#include "sim/sweep/sweep_records.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "sim/sweep/sweep_values.h"
#include "sim/sweep/whole_file.h"

namespace weft::sim {

namespace {

// Returns a field of a CSV file (RFC 4180).
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

std::string three_decimals(double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.3f", value);
  return buffer.data();
}

std::string summary_line(std::size_t index, const PlannedRun& run, const RunRecord& record) {
  const bool has_ended = record.state == RunState::done || record.state == RunState::failed;
  const RunResult& result = record.result;
  std::string line = std::to_string(index + 1) + ',' + run.hash.substr(0, 16) + ',' +
                     state_name(record.state) + ',' + failure_name(result.failure) + ',' +
                     csv_field(result.reason);
  for (const std::string& value : run.values) line += ',' + csv_field(plain_text(value));
  if (!has_ended) return line + ",,,,\n";
  return line + ',' + three_decimals(result.wall_seconds) + ',' +
         three_decimals(result.cpu_seconds) + ',' + three_decimals(result.peak_memory) + ',' +
         result.version + '\n';
}

}  // namespace

std::vector<RunRecord> read_records(const std::filesystem::path& directory, const SweepPlan& plan) {
  std::vector<RunRecord> records;
  records.reserve(plan.runs.size());
  for (const PlannedRun& run : plan.runs) {
    RunRecord& record = records.emplace_back();
    if (!run.refusal.empty()) {
      record.state = RunState::failed;
      record.result.failure = RunResult::Failure::bad_case;
      record.result.reason = run.refusal;
      continue;
    }
    const RunFolder folder(directory, run.hash);
    if (auto result = folder.result()) {
      record.state = result->is_done() ? RunState::done : RunState::failed;
      record.result = std::move(*result);
    } else {
      record.state = folder.state_without_result();
    }
  }
  return records;
}

RecordCounts count_records(const std::vector<RunRecord>& records) {
  const auto count = [&](RunState state) {
    return static_cast<int>(std::ranges::count(records, state, &RunRecord::state));
  };
  return {count(RunState::done), count(RunState::failed), count(RunState::interrupted),
          count(RunState::running), count(RunState::not_begun)};
}

std::string counts_text(const RecordCounts& counts) {
  const std::pair<int, RunState> all[] = {{counts.done, RunState::done},
                                          {counts.failed, RunState::failed},
                                          {counts.interrupted, RunState::interrupted},
                                          {counts.running, RunState::running},
                                          {counts.not_begun, RunState::not_begun}};
  std::string text;
  for (const auto& [count, state] : all) {
    if (count > 0)
      text += (text.empty() ? "" : ", ") + std::to_string(count) + ' ' + state_name(state);
  }
  return text;
}

void write_summary(const std::filesystem::path& directory, const SweepPlan& plan,
                   const std::vector<RunRecord>& records) {
  std::string text = "run,hash,status,failure,reason";
  for (const std::string& factor : plan.factors) text += ',' + csv_field(factor);
  text += ",wall_s,cpu_s,peak_memory_mib,weft_version\n";
  for (std::size_t i = 0; i < plan.runs.size(); ++i)
    text += summary_line(i, plan.runs[i], records[i]);
  write_whole_file(directory / "summary.csv", text);
}

std::string values_text(const SweepPlan& plan, const PlannedRun& run) {
  std::string text;
  for (std::size_t i = 0; i < plan.factors.size(); ++i)
    text += (text.empty() ? "" : ", ") + plan.factors[i] + " = " + run.values[i];
  return text;
}

}  // namespace weft::sim
