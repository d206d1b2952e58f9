#include "sim/sweep/sweep_records.h"

#include <algorithm>
#include <utility>

namespace weft::sim {

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

std::string values_text(const SweepPlan& plan, const PlannedRun& run) {
  std::string text;
  for (std::size_t i = 0; i < plan.factors.size(); ++i)
    text += (text.empty() ? "" : ", ") + plan.factors[i] + " = " + run.values[i];
  return text;
}

}  // namespace weft::sim
