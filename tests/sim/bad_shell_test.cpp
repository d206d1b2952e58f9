// Shells that must be refused, with place and hint.
#include "sim/case/case_error.h"
#include "sim/scene/scene.h"
#include "tests/sim/bad_case.h"

namespace weft::sim::bad_shell_test {

namespace {

// A shell of 5 x 9 control points with this modulus (line 3) and this ratio (line 4), and with more
// keys from line 7 on.
std::string shell(const std::string& modulus, const std::string& ratio,
                  const std::string& more = "") {
  return "[material.m]\nmodel = \"shell\"\nyoungs_modulus = " + modulus +
         "\npoisson_ratio = " + ratio + "\nshell_thickness = 1e-3\nvolume_density = 1000\n" + more;
}

// Lists one case per row: its name, the text, the whole message.
std::vector<BadCase> bad_shells() {
  return {
      {"modulus_of_zero", shell("0", "0.3") + sheet,
       R"(case.toml:3:18: "youngs_modulus" is 0
  expected a number > 0 (Pa))"},
      {"negative_modulus", shell("-1e9", "0.3") + sheet,
       R"(case.toml:3:18: "youngs_modulus" is -1e+09
  expected a number > 0 (Pa))"},
      {"ratio_beyond_a_half", shell("1e9", "0.6") + sheet,
       R"(case.toml:4:17: poisson_ratio is 0.6
  expected at most 0.5 with model = "shell": a solid whose ratio is larger would gain energy under pressure)"},
      {"ratio_of_minus_one", shell("1e9", "-1") + sheet,
       R"(case.toml:4:17: "poisson_ratio" is -1
  expected a number > -1 and < 1)"},
      {"membrane_of_cloth", shell("1e9", "0.3", "membrane_stiffness = 10\n") + sheet,
       R"(case.toml:7:1: "membrane_stiffness" does not belong to model = "shell"
  expected only with model = "cloth")"},
  };
}

class BadShell : public testing::TestWithParam<BadCase> {};
TEST_P(BadShell, IsRefused) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, BadShell, testing::ValuesIn(bad_shells()), bad_case_name);

// Images that are found too small when the scene is built.
std::vector<BadCase> small_images() {
  return {
      {"too_few_control_points",
       shell("1e9", "0.3") +
           "[[body]]\nname = \"s\"\nshape = { type = \"rectangle\", size = [1, 1], resolution = "
           "[3, 8] }\n",
       R"(case.toml:9:9: the image of "s" has 3 x 8 control points
  expected at least 4 x 4 with spline_degree = 3)"},
      {"too_few_for_degree_two",
       shell("1e9", "0.3", "spline_degree = 2\n") +
           "[[body]]\nname = \"s\"\nshape = { type = \"rectangle\", size = [1, 1], resolution = "
           "[2, 8] }\n",
       R"(case.toml:10:9: the image of "s" has 2 x 8 control points
  expected at least 3 x 3 with spline_degree = 2)"},
  };
}

class SmallImage : public testing::TestWithParam<BadCase> {};
TEST_P(SmallImage, IsRefused) {
  try {
    static_cast<void>(build_scene(parse_case(GetParam().text, "case.toml")));
    FAIL() << "accepted:\n" << GetParam().text;
  } catch (const CaseError& error) {
    EXPECT_EQ(error.what(), GetParam().what);
  }
}
INSTANTIATE_TEST_SUITE_P(All, SmallImage, testing::ValuesIn(small_images()), bad_case_name);

}  // namespace

}  // namespace weft::sim::bad_shell_test
