#include "sim/sweep/sweep_outputs.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/probes/outputs.h"
#include "sim/run/output_check.h"
#include "sim/run/restart.h"
#include "sim/scene/scene.h"
#include "sim/sweep/sweep_values.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;

// Returns the values of outputs by their expressions. Calls complain(reason) for each that the
// trajectory cannot answer, and once for a trajectory that cannot be read.
std::map<std::string, double> evaluate(const fs::path& trajectory,
                                       const std::vector<OutputExpression>& outputs,
                                       const std::function<void(const std::string&)>& complain) {
  std::map<std::string, double> values;
  std::error_code unknown;
  if (outputs.empty() || !fs::exists(trajectory, unknown)) return values;
  try {
    const TrajectoryReader reader(trajectory.string());
    for (const OutputExpression& output : outputs) {
      try {
        values[output.text.text] = evaluate_outputs({output}, reader).front().second;
      } catch (const CaseError& error) {
        complain(error.what());
      }
    }
  } catch (const FileError& error) {
    complain(error.what());
  }
  return values;
}

// Throws CaseError if an output has the name of another column of the summary.
void refuse_names_of_columns(const std::vector<OutputExpression>& outputs) {
  for (const OutputExpression& output : outputs) {
    if (std::ranges::find(first_columns, output.name) == first_columns.end() &&
        std::ranges::find(last_columns, output.name) == last_columns.end())
      continue;
    throw CaseError(
        output.text.location,
        "the output " + in_quotes(output.name) + " has the name of a column of every summary",
        "expected another name");
  }
}

// Largest number of runs that are set up to check outputs, if none of them can be set up.
constexpr int most_tries = 10;

// Throws CaseError if an output asks for what a run does not record. Returns false if the run
// cannot be set up, for example because its shape file is damaged.
bool check_outputs_of(const PlannedRun& run, const SweepPlan& plan,
                      const std::vector<OutputExpression>& outputs) {
  // Lines of the resolved case mean nothing to the user, so its faults are told by another path.
  const std::string path = plan.sweep + ": resolved case";
  Case source = parse_case(run.case_text, path);
  source.outputs = outputs;
  try {
    if (source.awaits_accuracy()) {
      check_outputs_before_pilot(source, plan.estimate_error);
    } else {
      read_restart(source);
      check_outputs(*build_scene(source), plan.estimate_error);
    }
  } catch (const CaseError& error) {
    // The run fails by itself, with the place in its case.
    if (error.where().file == path) return false;
    throw;
  }
  return true;
}

FactorValue factor_value(const std::string& toml) { return {plain_text(toml), number_of(toml)}; }

}  // namespace

std::vector<OutputExpression> joined_outputs(std::vector<OutputExpression> of_case,
                                             const std::vector<OutputExpression>& of_sweep) {
  for (const OutputExpression& output : of_sweep) {
    const auto same = std::ranges::find(of_case, output.name, &OutputExpression::name);
    if (same == of_case.end()) {
      of_case.push_back(output);
    } else {
      *same = output;
    }
  }
  return of_case;
}

void check_outputs(const SweepPlan& plan) {
  const auto outputs = joined_outputs(plan.case_outputs, plan.sweep_outputs);
  refuse_names_of_columns(outputs);
  if (outputs.empty()) return;
  int tries = 0;
  for (const PlannedRun& run : plan.runs) {
    if (!run.refusal.empty()) continue;
    if (check_outputs_of(run, plan, outputs) || ++tries == most_tries) return;
  }
}

std::map<std::string, double> output_values(const fs::path& trajectory,
                                            const std::vector<OutputExpression>& outputs) {
  return evaluate(trajectory, outputs, [](const std::string&) {});
}

OutputCollector::OutputCollector(fs::path directory, std::vector<OutputExpression> outputs,
                                 bool anew)
    : directory_(std::move(directory)), outputs_(std::move(outputs)), anew_(anew) {}

const std::vector<double>& OutputCollector::values(const std::string& hash,
                                                   const RunResult& result) {
  const auto known = values_.find(hash);
  return known != values_.end() ? known->second
                                : values_.emplace(hash, compute(hash, result)).first->second;
}

std::vector<double> OutputCollector::compute(const std::string& hash, const RunResult& result) {
  std::map<std::string, double> found = result.outputs;
  const bool has_all = std::ranges::all_of(
      outputs_, [&](const OutputExpression& output) { return found.contains(output.text.text); });
  const fs::path trajectory = RunFolder(directory_, hash).path() / "run.h5";
  std::error_code unknown;
  if ((anew_ || !has_all) && fs::exists(trajectory, unknown)) {
    auto of_trajectory = evaluate(trajectory, outputs_, [&](const std::string& reason) {
      if (std::ranges::find(complaints_, reason) == complaints_.end())
        complaints_.push_back(reason);
    });
    of_trajectory.merge(found);  // of a trajectory that is damaged since, the result has them still
    found = std::move(of_trajectory);
  }
  std::vector<double> values;
  for (const OutputExpression& output : outputs_) {
    const auto value = found.find(output.text.text);
    values.push_back(value != found.end() ? value->second
                                          : std::numeric_limits<double>::quiet_NaN());
  }
  return values;
}

Summary summary_of(const SweepPlan& plan, const std::vector<RunRecord>& records,
                   OutputCollector& collector) {
  Summary summary;
  summary.factors = plan.factors;
  for (const OutputExpression& output : collector.outputs()) summary.outputs.push_back(output.name);
  const std::vector<double> none(summary.outputs.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    const PlannedRun& run = plan.runs[i];
    const auto& [state, result] = records[i];
    SummaryRow& row = summary.rows.emplace_back();
    row.hash = run.hash.substr(0, 16);
    row.status = state_name(state);
    row.failure = failure_name(result.failure);
    row.reason = result.reason;
    for (const std::string& value : run.values) row.factors.push_back(factor_value(value));
    row.has_ended = state == RunState::done || state == RunState::failed;
    const bool has_begun = row.has_ended && run.refusal.empty();
    row.outputs = has_begun ? collector.values(run.hash, result) : none;
    row.wall_time = result.wall_seconds;
    row.cpu_time = result.cpu_seconds;
    row.peak_memory = result.peak_memory;
    row.version = result.version;
  }
  return summary;
}

void write_summary(const fs::path& directory, const SweepPlan& plan,
                   const std::vector<RunRecord>& records, OutputCollector& collector) {
  write_summary(summary_of(plan, records, collector), directory);
}

}  // namespace weft::sim
