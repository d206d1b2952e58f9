// Sweep files that must be refused, with the place of the fault and a hint.
#include <gtest/gtest.h>

#include <ostream>

#include "sim/case/case_error.h"
#include "sim/sweep/sweep_plan.h"
#include "sim/sweep/sweep_reader.h"
#include "tests/temporary_folder.h"

namespace weft::sim::bad_sweep_test {

namespace {

struct BadSweep {
  std::string name;
  std::string text;
  std::string what;  // the whole message: place, reason and hint
};

std::ostream& operator<<(std::ostream& stream, const BadSweep& bad) { return stream << bad.name; }

// The case that the sweeps start from.
constexpr const char* base_case = R"([material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
)";

std::vector<BadSweep> bad_sweeps() {
  return {
      {"toml_value_missing",
       R"(case =
)",
       R"(sweep.toml:1:7: not TOML: Error while parsing key-value pair
  expected value, saw '\n')"},
      {"unknown_table",
       R"(case = "base.toml"
[facters]
"contact.friction" = { list = [0.1] }
)",
       R"(sweep.toml:2:2: unknown key "facters" in the sweep
  did you mean "factors"?)"},
      {"unknown_key_of_sample",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
methode = "grid"
)",
       R"(sweep.toml:5:1: unknown key "methode" in [sample]
  did you mean "method"?)"},
      {"unknown_key_of_factor",
       R"(case = "base.toml"
[factors]
"contact.friction" = { unifrom = [0.1, 0.2] }
)",
       R"(sweep.toml:3:24: unknown key "unifrom" in [factors.contact.friction]
  did you mean "uniform"?)"},
      {"no_case",
       R"([factors]
"contact.friction" = { list = [0.1, 0.2] }
)",
       R"(sweep.toml:1:1: the sweep has no "case"
  expected "case", a string)"},
      {"case_not_a_string",
       R"(case = 3
[factors]
"contact.friction" = { list = [0.1, 0.2] }
)",
       R"(sweep.toml:1:8: "case" is a whole number
  expected a string)"},
      {"case_not_there",
       R"(case = "bse.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
)",
       R"(sweep.toml:1:8: "bse.toml" cannot be read: No such file or directory
  expected a case file, here bse.toml)"},
      {"no_factors",
       R"(case = "base.toml"
)",
       R"(sweep.toml:1:1: the sweep has no factors
  expected [factors], with case keys in quotes)"},
      {"factor_without_values",
       R"(case = "base.toml"
[factors]
"contact.friction" = {}
)",
       R"(sweep.toml:3:22: "contact.friction" has no values
  expected one of "list", "range", "uniform", "log_uniform")"},
      {"factor_not_a_table",
       R"(case = "base.toml"
[factors]
"contact.friction" = [0.1, 0.2]
)",
       R"(sweep.toml:3:22: "contact.friction" is an array
  expected a table, such as { list = [0.1, 0.2] })"},
      {"factor_key_without_quotes",
       R"(case = "base.toml"
[factors]
contact.friction = { list = [0.1] }
)",
       R"(sweep.toml:3:1: "contact" is a table
  expected a case key in quotes: "contact.friction" = { list = [...] })"},
      {"factor_unknown_key",
       R"(case = "base.toml"
[factors]
"contact.frictoin" = { list = [0.1] }
)",
       R"(sweep.toml:3:1: unknown key "frictoin" in [contact]
  did you mean "friction"?)"},
      {"factor_unknown_material",
       R"(case = "base.toml"
[factors]
"material.coton.density" = { list = [0.1] }
)",
       R"(sweep.toml:3:1: the case has no "material.coton"
  did you mean "cotton"?)"},
      {"factor_is_a_table_of_the_case",
       R"(case = "base.toml"
[factors]
"contact" = { list = [0.1] }
)",
       R"(sweep.toml:3:23: "contact" is a number with a point or exponent
  expected a table, [contact])"},
      {"factor_key_of_no_body",
       R"(case = "base.toml"
[factors]
"body.shet.thickness" = { list = [1e-3] }
)",
       R"(sweep.toml:3:1: the case has no "body.shet"
  did you mean "sheet"?)"},
      {"list_empty",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [] }
)",
       R"(sweep.toml:3:31: "list" is an array of 0
  expected an array of values)"},
      {"list_value_beyond_limit",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2,
  -0.3] }
)",
       R"(sweep.toml:4:3: "friction" is -0.3
  expected a number >= 0 or a curve)"},
      {"list_value_of_wrong_type",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, "high"] }
)",
       R"(sweep.toml:3:37: "friction" is a string
  expected a number >= 0 or a curve)"},
      {"list_name_unknown",
       R"(case = "base.toml"
[factors]
"time.method" = { list = ["euler", "cvod"] }
)",
       R"(sweep.toml:3:36: "method" is "cvod"
  did you mean "cvode"?)"},
      {"list_number_for_string",
       R"(case = "base.toml"
[factors]
"title" = { list = ["a", 5] }
)",
       R"(sweep.toml:3:26: "title" is a whole number
  expected a string)"},
      {"list_and_uniform",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1], uniform = [0.1, 0.2] }
[sample]
method = "random"
runs = 3
)",
       R"(sweep.toml:3:38: "uniform" does not go with "list"
  expected only one of the two)"},
      {"range_of_one",
       R"(case = "base.toml"
[factors]
"contact.friction" = { range = [0.1], count = 3 }
)",
       R"(sweep.toml:3:32: "range" is an array of 1
  expected an array of 2 numbers)"},
      {"range_without_count",
       R"(case = "base.toml"
[factors]
"contact.friction" = { range = [0.1, 0.5] }
)",
       R"(sweep.toml:3:32: "contact.friction" has a range without "count"
  expected "count", the number of values)"},
      {"count_without_range",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1], count = 3 }
)",
       R"(sweep.toml:3:38: "count" does not belong here
  expected only with "range")"},
      {"count_of_one",
       R"(case = "base.toml"
[factors]
"contact.friction" = { range = [0.1, 0.5], count = 1 }
)",
       R"(sweep.toml:3:52: "count" is 1
  expected a whole number >= 2 and <= 1e+06)"},
      {"count_of_billions",
       R"(case = "base.toml"
[factors]
"contact.friction" = { range = [0.1, 0.5], count = 2000000000 }
)",
       R"(sweep.toml:3:52: "count" is 2000000000
  expected a whole number >= 2 and <= 1e+06)"},
      {"range_end_beyond_limit",
       R"(case = "base.toml"
[factors]
"material.cotton.density" = { range = [0.0, 0.5], count = 3 }
)",
       R"(sweep.toml:3:39: "density" is 0
  expected a number > 0 (kg/m^2))"},
      {"range_of_too_few_numbers",
       R"(case = "base.toml"
[factors]
"contact.friction" = { range = [0.5, 0.5000000000000002], count = 4 }
)",
       R"(sweep.toml:3:32: "contact.friction" has a range of fewer numbers than 4 values
  expected a smaller "count", or ends farther apart)"},
      {"range_of_huge_whole_numbers",
       R"(case = "base.toml"
[factors]
"body.sheet.shape.resolution.0" = { range = [1e19, 3e19], count = 3 }
)",
       R"(sweep.toml:3:45: "resolution[0]" is a number with a point or exponent
  expected an array of 1 to 3 whole numbers >= 2)"},
      {"factor_by_two_names",
       R"(case = "base.toml"
[factors]
"body.sheet.shape.resolution.1" = { list = [5, 9] }
"body.0.shape.resolution.01" = { list = [7] }
)",
       R"(sweep.toml:4:1: "body.0.shape.resolution.01" is the same key as "body.sheet.shape.resolution.1"
  expected it once in a sweep)"},
      {"factor_and_set_by_two_names",
       R"(case = "base.toml"
[set]
"body.sheet.position.2" = 1.0
[factors]
"body.0.position.2" = { list = [1.0, 2.0] }
)",
       R"(sweep.toml:5:1: "body.0.position.2" is the same key as "body.sheet.position.2"
  expected it once in a sweep)"},
      {"listed_run_by_two_names",
       R"(case = "base.toml"
[sample]
method = "list"
[[run]]
set = { "body.sheet.position.2" = 1.0, "body.0.position.2" = 2.0 }
)",
       R"(sweep.toml:5:40: "body.0.position.2" is the same key as "body.sheet.position.2"
  expected it once in a sweep)"},
      {"range_of_whole_numbers_with_fractions",
       R"(case = "base.toml"
[factors]
"body.sheet.shape.resolution.0" = { range = [5, 8], count = 3 }
)",
       R"(sweep.toml:3:45: "body.sheet.shape.resolution.0" takes whole numbers, and the range has 6.5
  expected a "count" with a whole number between two values)"},
      {"uniform_for_boolean",
       R"(case = "base.toml"
[factors]
"contact.enabled" = { uniform = [0, 1] }
[sample]
method = "random"
runs = 3
)",
       R"(sweep.toml:3:33: "enabled" is a whole number
  expected true or false)"},
      {"uniform_reversed",
       R"(case = "base.toml"
[factors]
"contact.friction" = { uniform = [0.5, 0.1] }
[sample]
method = "random"
runs = 3
)",
       R"(sweep.toml:3:34: "contact.friction" has samples from 0.5 to 0.1
  expected the least value before the largest one)"},
      {"uniform_in_a_grid",
       R"(case = "base.toml"
[factors]
"contact.friction" = { uniform = [0.1, 0.5] }
)",
       R"(sweep.toml:3:24: "contact.friction" has samples, which this sample.method does not take
  expected "list" or "range", or a sample.method of "random", "latin_hypercube" or "sobol")"},
      {"uniform_end_beyond_limit",
       R"(case = "base.toml"
[factors]
"contact.friction" = { uniform = [-0.1, 0.5] }
[sample]
method = "sobol"
runs = 3
)",
       R"(sweep.toml:3:34: "friction" is -0.1
  expected a number >= 0 or a curve)"},
      {"log_uniform_from_zero",
       R"(case = "base.toml"
[factors]
"material.cotton.density" = { log_uniform = [0, 0.4] }
[sample]
method = "sobol"
runs = 3
)",
       R"(sweep.toml:3:46: "log_uniform[0]" is 0
  expected an array of 2 numbers > 0)"},
      {"method_unknown",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
method = "sobel"
runs = 3
)",
       R"(sweep.toml:5:10: "method" is "sobel"
  did you mean "sobol"?)"},
      {"runs_missing",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
method = "random"
)",
       R"(sweep.toml:4:1: [sample] has no "runs"
  expected "runs", a whole number >= 1 and <= 1e+06)"},
      {"runs_auto",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
method = "random"
runs = "auto"
)",
       R"(sweep.toml:6:8: "runs" is a string
  expected a whole number >= 1 and <= 1e+06)"},
      {"runs_of_a_grid",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
runs = 3
)",
       R"(sweep.toml:5:1: "runs" does not belong to method = "grid"
  expected only with method = "random", "latin_hypercube", "sobol")"},
      {"runs_none",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
method = "random"
runs = 0
)",
       R"(sweep.toml:6:8: "runs" is 0
  expected a whole number >= 1 and <= 1e+06)"},
      {"seed_negative",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
method = "random"
runs = 3
seed = -1
)",
       R"(sweep.toml:7:8: "seed" is -1
  expected a whole number >= 0)"},
      {"zip_of_unequal_lists",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
"time.duration" = { list = [0.1, 0.2, 0.3] }
[sample]
method = "zip"
)",
       R"(sweep.toml:4:1: "time.duration" has 3 values, and "contact.friction" has 2
  expected as many values for each factor of sample.method = "zip")"},
      {"set_unknown_key",
       R"(case = "base.toml"
[set]
"time.duraton" = 0.25
[factors]
"contact.friction" = { list = [0.1, 0.2] }
)",
       R"(sweep.toml:3:1: unknown key "duraton" in [time]
  did you mean "duration"?)"},
      {"set_value_beyond_limit",
       R"(case = "base.toml"
[set]
"time.duration" = 0
[factors]
"contact.friction" = { list = [0.1, 0.2] }
)",
       R"(sweep.toml:3:19: "duration" is 0
  expected a number > 0 (s))"},
      {"set_key_without_quotes",
       R"(case = "base.toml"
[set]
time.duration = 0.25
[factors]
"contact.friction" = { list = [0.1, 0.2] }
)",
       R"(sweep.toml:3:1: "time" is a table
  expected a case key in quotes: "time.duration" = VALUE)"},
      {"set_key_of_a_factor",
       R"(case = "base.toml"
[set]
"contact.friction" = 0.25
[factors]
"contact.friction" = { list = [0.1, 0.2] }
)",
       R"(sweep.toml:3:1: "contact.friction" varies in this sweep
  expected it either in [set] or as a factor)"},
      {"list_method_without_runs",
       R"(case = "base.toml"
[sample]
method = "list"
)",
       R"(sweep.toml:3:10: sample.method = "list" without runs
  expected tables [[run]] with a key "set")"},
      {"list_method_with_factors",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
method = "list"
[[run]]
set = { "contact.friction" = 0.1 }
)",
       R"(sweep.toml:2:2: [factors] do not belong to sample.method = "list"
  expected all values in the tables [[run]])"},
      {"listed_runs_of_other_keys",
       R"(case = "base.toml"
[sample]
method = "list"
[[run]]
set = { "contact.friction" = 0.1 }
[[run]]
set = { "time.duration" = 0.1 }
)",
       R"(sweep.toml:6:1: this [[run]] has other keys than the first one
  expected "contact.friction")"},
      {"listed_run_value_beyond_limit",
       R"(case = "base.toml"
[sample]
method = "list"
[[run]]
set = { "contact.friction" = 0.1 }
[[run]]
set = { "contact.friction" = -0.1 }
)",
       R"(sweep.toml:7:30: "friction" is -0.1
  expected a number >= 0 or a curve)"},
      {"listed_runs_in_a_grid",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[[run]]
set = { "contact.friction" = 0.1 }
)",
       R"(sweep.toml:4:3: [[run]] does not belong to this sample.method
  expected only with sample.method = "list")"},
      {"repeats_without_key",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
repeats = 3
)",
       R"(sweep.toml:5:11: the repeats would all be the same run
  expected "repeat_key", a case key that gets the number of the repeat)"},
      {"repeat_key_without_repeats",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
repeat_key = "world.wind.seed"
)",
       R"(sweep.toml:5:14: "repeat_key" without repeats
  expected "repeats" of at least 2)"},
      {"repeat_key_unknown",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
repeats = 3
repeat_key = "world.wind.sed"
)",
       R"(sweep.toml:6:14: unknown key "sed" in [world.wind]
  did you mean "seed"?)"},
      {"repeat_key_is_a_factor",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
repeats = 3
repeat_key = "contact.friction"
)",
       R"(sweep.toml:6:14: "contact.friction" has values of its own in this sweep
  expected a key that neither [set] nor a factor sets)"},
      {"rule_not_a_string",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
exclude = [3]
)",
       R"(sweep.toml:5:12: the rule 3 is not a string
  expected an expression in quotes, such as "contact.friction < 0.3")"},
      {"rule_with_unknown_factor",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
exclude = ["contact.frictoin > 0.1"]
)",
       R"(sweep.toml:5:13: unknown name "contact.frictoin"
  did you mean "contact.friction"?)"},
      {"rule_not_finished",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
include = ["contact.friction >"]
)",
       R"(sweep.toml:5:31: the expression ends where a value is expected
  expected a number, a name or a bracket)"},
      {"rules_leave_nothing",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[sample]
include = ["contact.friction > 1"]
)",
       R"(sweep.toml:4:1: the rules leave no run
  expected a combination for which all of "include" and none of "exclude" hold)"},
      {"limit_of_time_negative",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[limits]
time = -1
)",
       R"(sweep.toml:5:8: "time" is -1
  expected a number > 0 (s))"},
      {"limit_unknown",
       R"(case = "base.toml"
[factors]
"contact.friction" = { list = [0.1, 0.2] }
[limits]
memori = 1
)",
       R"(sweep.toml:5:1: unknown key "memori" in [limits]
  did you mean "memory"?)"},
      {"error_of_equilibria",
       R"(case = "base.toml"
estimate_error = true
[set]
"contact.enabled" = false
"body.sheet.pin" = [{ edges = ["first_row"] }]
[factors]
"time.method" = { list = ["static"] }
)",
       R"(sweep.toml:2:18: time.method = "static" has no error of time steps
  expected another time.method, or estimate_error = false)"},
      {"all_runs_refused",
       R"(case = "base.toml"
[factors]
"body.sheet.material" = { list = ["silk", "wool"] }
)",
       R"(sweep.toml:3:35: unknown material "silk"
  expected "cotton")"},
  };
}

class BadSweepTest : public testing::TestWithParam<BadSweep> {};

TEST_P(BadSweepTest, IsRefusedAtItsPlace) {
  const TemporaryFolder folder;
  folder.write("base.toml", base_case);
  try {
    plan_sweep(parse_sweep(GetParam().text, folder.path("sweep.toml")));
    FAIL() << "accepted:\n" << GetParam().text;
  } catch (const CaseError& error) {
    // The test's folder is not part of the expected message.
    std::string what = error.what();
    const std::string prefix = folder.path().string() + '/';
    for (std::size_t at = what.find(prefix); at != std::string::npos; at = what.find(prefix))
      what.erase(at, prefix.size());
    EXPECT_EQ(what, GetParam().what);
  }
}

INSTANTIATE_TEST_SUITE_P(Sweeps, BadSweepTest, testing::ValuesIn(bad_sweeps()),
                         [](const testing::TestParamInfo<BadSweep>& sweep) {
                           return sweep.param.name;
                         });

}  // namespace
}  // namespace weft::sim::bad_sweep_test
