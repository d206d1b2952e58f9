// Keys of a sweep of which one is a part of another one: their values must not hide each other.
#include "sim/sweep/sweep_keys.h"

#include <gtest/gtest.h>

#include <ostream>

#include "sim/case/case_error.h"
#include "sim/sweep/sweep_plan.h"
#include "sim/sweep/sweep_reader.h"
#include "tests/temporary_folder.h"

namespace weft::sim::sweep_keys_test {
namespace {

constexpr const char* base_case = R"(
[material.cotton]
density = 0.2
[material.cotton-2]
density = 0.3
[[body]]
name = "sheet"
material = "cotton"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
)";

struct Sweep {
  std::string name;
  std::string text;  // after the line of the case
  std::vector<std::string> overrides;
  std::string what;  // the message without the folder; empty for a sweep that is accepted
};

std::ostream& operator<<(std::ostream& stream, const Sweep& sweep) { return stream << sweep.name; }

std::vector<Sweep> factors() {
  return {
      {"whole_after_part",
       R"([factors]
"time.duration" = { list = [0.05, 0.06] }
"time" = { list = [{ duration = 0.04 }] }
)",
       {},
       R"(sweep.toml:4:1: "time.duration" is a part of "time", and both vary in this sweep
  expected one of the two)"},
      {"part_after_whole",
       R"([factors]
"time" = { list = [{ duration = 0.04 }] }
"time.duration" = { list = [0.05, 0.06] }
)",
       {},
       R"(sweep.toml:4:1: "time.duration" is a part of "time", and both vary in this sweep
  expected one of the two)"},
      {"whole_by_another_name",
       R"([factors]
"body.sheet.position.2" = { list = [1.0, 2.0] }
"body.0.position" = { list = [[0, 0, 3]] }
)",
       {},
       R"(sweep.toml:4:1: "body.sheet.position.2" is a part of "body.0.position", and both vary in this sweep
  expected one of the two)"},
      {"listed_runs",
       R"([sample]
method = "list"
[[run]]
set = { "time" = { duration = 0.04 }, "time.duration" = 0.05 }
)",
       {},
       R"(sweep.toml:5:39: "time.duration" is a part of "time", and both vary in this sweep
  expected one of the two)"},
      {"key_of_repeats",
       R"([factors]
"time" = { list = [{ duration = 0.04 }] }
[sample]
repeats = 2
repeat_key = "time.duration"
)",
       {},
       R"(sweep.toml:6:14: "time.duration" is a part of "time", and both vary in this sweep
  expected one of the two)"},
      // Neither name is a part of the other one.
      {"names_that_begin_alike",
       R"([factors]
"material.cotton" = { list = [{ density = 0.1 }, { density = 0.2 }] }
"material.cotton-2.density" = { list = [0.3] }
)",
       {},
       ""},
  };
}

std::vector<Sweep> fixed_values() {
  return {
      {"part_in_set",
       R"([set]
"body.sheet.position.2" = 1.0
[factors]
"body.0.position" = { list = [[0, 0, 3]] }
)",
       {},
       R"(sweep.toml:3:1: "body.sheet.position.2" is a part of "body.0.position", which varies in this sweep
  expected a key that is no part of a factor)"},
      {"part_in_option",
       R"([factors]
"body.sheet.position" = { list = [[0, 0, 3]] }
)",
       {"body.sheet.position.2=1"},
       R"(--set body.sheet.position.2=1: "body.sheet.position.2" is a part of "body.sheet.position", which varies in this sweep
  expected a key that is no part of a factor)"},
      {"whole_in_set",
       R"([set]
"time" = { duration = 0.5 }
[factors]
"time.duration" = { list = [0.05, 0.06] }
)",
       {},
       R"(sweep.toml:3:1: "time" has a value of "time.duration", which varies in this sweep
  expected a value without that key)"},
      {"whole_in_option",
       R"([factors]
"time.duration" = { list = [0.05, 0.06] }
)",
       {"time={duration=0.5}"},
       R"(--set time={duration=0.5}: "time" has a value of "time.duration", which varies in this sweep
  expected a value without that key)"},
      {"bodies_in_set",
       R"([set]
"body" = [{ name = "flag", material = "cotton", position = [0, 0, 1], shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] } }]
[factors]
"body.flag.position" = { list = [[0, 0, 3]] }
)",
       {},
       R"(sweep.toml:3:1: "body" has a value of "body.flag.position", which varies in this sweep
  expected a value without that key)"},
      // The factor adds to the table.
      {"whole_without_the_part",
       R"([set]
"time" = { relative_tolerance = 1e-4 }
[factors]
"time.duration" = { list = [0.05, 0.06] }
)",
       {},
       ""},
      {"preset_with_the_part",
       R"([set]
"material.cotton" = { preset = "wool" }
[factors]
"material.cotton.density" = { list = [0.3, 0.4] }
)",
       {},
       ""},
      // An array cannot leave out the entry that varies.
      {"whole_array",
       R"([set]
"body.sheet.position" = [1, 2, 3]
[factors]
"body.sheet.position.2" = { list = [4.0, 5.0] }
)",
       {},
       ""},
  };
}

std::vector<Sweep> keys_of_set() {
  const std::string factor = "[factors]\n\"material.cotton.density\" = { list = [0.1, 0.2] }\n";
  return {
      {"set_whole_after_part",
       R"([set]
"time.duration" = 0.05
"time" = { relative_tolerance = 1e-4 }
)" + factor,
       {},
       R"(sweep.toml:4:1: "time" replaces "time.duration", a part of it that [set] has before
  expected the part after the whole, or one of the two)"},
      {"set_by_two_names",
       R"([set]
"body.sheet.position.2" = 1.0
"body.0.position.2" = 2.0
)" + factor,
       {},
       R"(sweep.toml:4:1: "body.0.position.2" is the same key as "body.sheet.position.2"
  expected it once in a sweep)"},
      {"set_part_after_whole",
       R"([set]
"time" = { relative_tolerance = 1e-4 }
"time.duration" = 0.05
)" + factor,
       {},
       ""},
      // Options change what [set] and options before them say.
      {"options_after_set",
       R"([set]
"time.duration" = 0.05
)" + factor,
       {"time.duration=0.06", "time={duration=0.07}"},
       ""},
  };
}

class SweepKeysTest : public testing::TestWithParam<Sweep> {};

TEST_P(SweepKeysTest, RefusesValuesThatWouldBeLost) {
  const TemporaryFolder folder;
  folder.write("base.toml", base_case);
  std::string what;
  try {
    plan_sweep(parse_sweep("case = \"base.toml\"\n" + GetParam().text, folder.path("sweep.toml")),
               GetParam().overrides);
  } catch (const CaseError& error) {
    what = error.what();
  }
  const std::string prefix = folder.path().string() + '/';
  if (what.starts_with(prefix)) what.erase(0, prefix.size());
  EXPECT_EQ(what, GetParam().what);
}

std::string name_of(const testing::TestParamInfo<Sweep>& sweep) { return sweep.param.name; }

INSTANTIATE_TEST_SUITE_P(Factors, SweepKeysTest, testing::ValuesIn(factors()), name_of);
INSTANTIATE_TEST_SUITE_P(FixedValues, SweepKeysTest, testing::ValuesIn(fixed_values()), name_of);
INSTANTIATE_TEST_SUITE_P(KeysOfSet, SweepKeysTest, testing::ValuesIn(keys_of_set()), name_of);

}  // namespace
}  // namespace weft::sim::sweep_keys_test
