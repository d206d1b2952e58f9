// Describes the tables of a sweep file.
#include "sim/case/field_makers.h"
#include "sim/sweep/sweep_case.h"

namespace weft::sim {

// As for cases, a new member of a struct does not compile until a structured binding names it.

Table describe(FactorCase& target) {
  auto& [key, list, range, count, uniform, log_uniform, location, key_location, numbers_location] =
      target;
  Table result{{
      field("list", &list, "Values of any type that the case key takes."),
      field("range", &range, "", any,
            "First and last value, between which `count` values lie evenly.")
          .entries(2, 2)
          .not_with("list"),
      field("count", &count, "", Limits{2, 1e6, false, false},
            "Number of values of `range`, with both ends.")
          .with_default("none"),
      field("uniform", &uniform, "", any, "Least and largest value of uniform samples.")
          .entries(2, 2)
          .not_with("list")
          .not_with("range"),
      field("log_uniform", &log_uniform, "", positive,
            "Least and largest value of samples whose logarithm is uniform.")
          .entries(2, 2)
          .not_with("list")
          .not_with("range")
          .not_with("uniform"),
  }};
  result.name = &key;
  result.location = &location;
  return result;
}

Table describe(SampleCase& target) {
  auto& [method, runs, seed, repeats, repeat_key, include, exclude] = target;
  return {{
      field(
          "method",
          choice(&method, {{SampleMethod::grid, "grid"},
                           {SampleMethod::zip, "zip"},
                           {SampleMethod::list, "list"},
                           {SampleMethod::random, "random"},
                           {SampleMethod::latin_hypercube, "latin_hypercube"},
                           {SampleMethod::sobol, "sobol"}}),
          "How values make runs. grid: every combination, the last factor changing first. zip: the "
          "first values of all factors, the second ones, and so on. list: the tables [[run]]. "
          "random: independent samples. latin_hypercube: one sample in each of as many equal "
          "intervals as there are runs. sobol: points of the Sobol sequence."),
      field("runs", &runs, "", Limits{1, 1e6, false, false}, "Number of samples.")
          .needed()
          .only_for("method", {"random", "latin_hypercube", "sobol"}),
      field("seed", &seed, "", at_least(0),
            "Number that chooses the samples. With sobol, 0 is the sequence itself, and other "
            "numbers shift it.")
          .only_for("method", {"random", "latin_hypercube", "sobol"}),
      field("repeats", &repeats, "", Limits{1, 1e6, false, false},
            "Runs per combination of values, which differ in `repeat_key`."),
      field("repeat_key", &repeat_key,
            "Case key that gets the number of the repeat, 1, 2, ..., such as \"world.wind.seed\".")
          .with_default("none"),
      field("include", &include,
            "Expressions over factors, which must all hold for a run: \"contact.friction < 0.3\".")
          .entries(0, 0),
      field("exclude", &exclude, "Expressions over factors; a run for which one holds is left out.")
          .entries(0, 0),
  }};
}

Table describe(LimitsCase& target) {
  auto& [time, memory] = target;
  return {{
      field("time", &time, "s", positive,
            "Wall time of a run since it was last started; one that takes longer is stopped and "
            "has failed. "
            "A run that goes on from a checkpoint has the whole time again.")
          .with_default("none"),
      field("memory", &memory, "MiB", positive,
            "Resident memory of a run; one that takes more is ended and has failed.")
          .with_default("none"),
  }};
}

Table describe(ListedRun& target) {
  auto& [set, location] = target;
  Table result{{field("set", &set,
                      "Case keys in quotes and their values in this run; the same keys in all "
                      "[[run]].")
                    .needed()}};
  result.location = &location;
  return result;
}

Table describe(SweepCase& target) {
  auto& [base, set, factors, sample, limits, estimate_error, run, outputs, path, text,
         base_location, factors_location, method_location, repeat_key_location, estimate_location] =
      target;
  TableList of_factors = tables(&factors, true);
  of_factors.named_by_case_keys = true;
  Table result{{
      field("case", &base, "Case file that all runs start from, relative to the sweep file.")
          .needed(),
      field("set", &set,
            "Case keys in quotes and their values in all runs: \"time.duration\" = 0.25.")
          .with_default("none"),
      field("factors", std::move(of_factors),
            "Case keys that vary. KEY is a key as for --set: \"material.cotton.density\". Each has "
            "either list, range, uniform or log_uniform."),
      field("sample", table(&sample), "How the values of the factors make runs."),
      field("limits", table(&limits), "Limits of each run."),
      field("estimate_error", &estimate_error,
            "Measure the error of each run by a second, more exact one, as weft run "
            "--estimate-error does: [outputs] may then use \"max(error_estimate_BODY)\"."),
      field("run", tables(&run), "Runs of sample.method = \"list\", one by one."),
      field("outputs", &outputs,
            "Numbers of each run for the summary: expressions over what it records, such as "
            "\"max(largest_stretch)\", by name. They join the [outputs] of the case, and replace "
            "those of the same names."),
  }};
  result.root_name = "the sweep";
  return result;
}

}  // namespace weft::sim
