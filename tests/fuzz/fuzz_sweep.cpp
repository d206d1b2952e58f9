#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/sweep/sweep_plan.h"
#include "sim/sweep/sweep_reader.h"
#include "tests/fuzz/fuzz_readers.h"
#include "tests/fuzz/input_files.h"

namespace weft::sim {

namespace {

constexpr double most_planned_runs = 64;

// Returns the number of runs before rules, which is at most that of the plan.
double runs_of(const SweepCase& sweep) {
  double runs = sweep.sample.repeats;
  if (is_sampled(sweep.sample.method)) return runs * sweep.sample.runs;
  if (sweep.sample.method == SampleMethod::list)
    return runs * static_cast<double>(sweep.run.size());
  for (const FactorCase& factor : sweep.factors) {
    const double values =
        factor.range.empty() ? static_cast<double>(factor.list.size()) : factor.count;
    runs = sweep.sample.method == SampleMethod::zip ? values * sweep.sample.repeats : runs * values;
  }
  return runs;
}

void require_runs(const SweepPlan& plan) {
  const bool are_whole = std::ranges::all_of(plan.runs, [&](const PlannedRun& run) {
    return run.values.size() == plan.factors.size() && run.hash.size() == 64 &&
           run.refusal.empty() != run.case_text.empty();
  });
  if (are_whole && !plan.runs.empty()) return;
  std::fprintf(stderr, "a plan with a run that is not whole\n");
  std::abort();
}

}  // namespace

void fuzz_sweep(std::string_view input) {
  const InputSections sections = split_sections(input);
  const InputFolder& folder = empty_input_folder();
  for (const auto& [name, text] : sections.named) folder.write(name, text);
  try {
    const SweepCase sweep = parse_sweep(sections.main, folder.path("sweep.toml"));
    if (runs_of(sweep) > most_planned_runs) return;
    const SweepPlan plan = plan_sweep(sweep);
    require_runs(plan);
    for (const PlannedRun& run : plan.runs) {
      if (run.refusal.empty()) parse_case(run.case_text, folder.path("case.toml"));
    }
  } catch (const CaseError&) {
  } catch (const FileError&) {  // of an input file of the case
  }
}

}  // namespace weft::sim
