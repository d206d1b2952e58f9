// The outputs of a sweep's runs, computed from their trajectories, and the summary with them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/sweep/summary.h"
#include "sim/sweep/sweep_plan.h"
#include "sim/sweep/sweep_records.h"

namespace weft::sim {

// Returns the outputs of a sweep: those of its case, then those of the sweep file. An output of the
// sweep file replaces one of the case with the same name.
std::vector<OutputExpression> joined_outputs(std::vector<OutputExpression> of_case,
                                             const std::vector<OutputExpression>& of_sweep);

// Throws CaseError if an output of the plan is at fault, has the name of another column of the
// summary, or asks for what the first run that can be set up does not record. Makes a simulation of
// that run, unless there are no outputs. Looks at no run if the first ten cannot be set up, since
// those fail by themselves.
void check_outputs(const SweepPlan& plan);

// Returns the values of outputs by their expressions, for the result of a run that has ended. Those
// that the trajectory cannot answer are left out, all if it cannot be read or is not there.
std::map<std::string, double> output_values(const std::filesystem::path& trajectory,
                                            const std::vector<OutputExpression>& outputs);

// Collects the outputs of runs, each run once.
class OutputCollector {
 public:
  // `anew`: from the trajectories, where they are there, even of runs whose results have the
  // outputs already. `directory` is the folder of the sweep.
  OutputCollector(std::filesystem::path directory, std::vector<OutputExpression> outputs,
                  bool anew = false);

  const std::vector<OutputExpression>& outputs() const { return outputs_; }
  // Returns the outputs of a run that has ended with this result, NaN for those that do not exist.
  // A run without a trajectory has those of its result. So has a run whose trajectory cannot be
  // read, or does not have what an output asks for, which adds a complaint.
  const std::vector<double>& values(const std::string& hash, const RunResult& result);
  // Forgets the outputs of a run that has ended anew.
  void forget(const std::string& hash) { values_.erase(hash); }
  // Returns the reasons why outputs could not be computed, each once.
  const std::vector<std::string>& complaints() const { return complaints_; }

 private:
  std::vector<double> compute(const std::string& hash, const RunResult& result);

  std::filesystem::path directory_;
  std::vector<OutputExpression> outputs_;
  bool anew_;
  std::map<std::string, std::vector<double>> values_;  // by hash
  std::vector<std::string> complaints_;
};

// Returns the summary of a plan whose runs have these states.
Summary summary_of(const SweepPlan& plan, const std::vector<RunRecord>& records,
                   OutputCollector& collector);
// Writes that summary into the folder of the sweep (summary.h). Throws FileError.
void write_summary(const std::filesystem::path& directory, const SweepPlan& plan,
                   const std::vector<RunRecord>& records, OutputCollector& collector);

}  // namespace weft::sim
