// A sweep file as data: a case, the keys that vary, and how their values are combined.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/case/case_schema.h"

namespace weft::sim {

// Values of one case key. Exactly one of the four lists of numbers or values is given.
struct FactorCase {
  std::string key;                  // KEY in [factors."KEY"]
  std::vector<TomlValue> list;      // values as they stand
  std::vector<double> range;        // [first, last]
  int count = 0;                    // number of values of a range, evenly spaced, ends included
  std::vector<double> uniform;      // [least, most]
  std::vector<double> log_uniform;  // [least, most], > 0
  SourceLocation location;          // place of the factor's table
  SourceLocation key_location;      // place of KEY
  SourceLocation numbers_location;  // place of `range`, `uniform` or `log_uniform`
};

// How the values of the factors make runs.
enum class SampleMethod { grid, zip, list, random, latin_hypercube, sobol };

struct SampleCase {
  SampleMethod method = SampleMethod::grid;
  int runs = 0;  // number of sampled runs, before rules and repeats
  int seed = 0;
  int repeats = 1;         // runs per combination, each with another number of `repeat_key`
  std::string repeat_key;  // case key that gets the number of the repeat, from 1
  // Rules over factors: a run is left out unless all of `include` and none of `exclude` hold.
  std::vector<TomlValue> include, exclude;
};

// Limits of one run. A run that exceeds them ends as failed.
struct LimitsCase {
  std::optional<double> time;    // s of wall time
  std::optional<double> memory;  // MiB of resident memory
};

// A run of sample.method = "list".
struct ListedRun {
  std::vector<KeyedValue> set;
  SourceLocation location;
};

struct SweepCase {
  std::string base;                       // path of the base case, relative to the sweep file
  std::vector<KeyedValue> set;            // [set]: overrides of all runs
  std::vector<FactorCase> factors;        // [factors], in the order of the file
  SampleCase sample;                      // [sample]
  LimitsCase limits;                      // [limits]
  bool estimate_error = false;            // runs measure their errors (weft run --estimate-error)
  std::vector<ListedRun> run;             // [[run]]
  std::vector<OutputExpression> outputs;  // [outputs], in the order of the file

  std::string path;  // path of the sweep file
  std::string text;  // text of the sweep file
  // Places of values, or of the nearest tables around them.
  SourceLocation base_location, factors_location, method_location, repeat_key_location,
      estimate_location;
};

Table describe(FactorCase& target);
Table describe(SampleCase& target);
Table describe(LimitsCase& target);
Table describe(ListedRun& target);
Table describe(SweepCase& target);

}  // namespace weft::sim
