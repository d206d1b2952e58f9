// Pairs of contact between cloth, obstacles and materials that must be refused.
#include "tests/sim/bad_case.h"

namespace weft::sim::bad_contact_pair_test {
namespace {

// Lines 1 to 13; a pair that follows begins in line 14.
const std::string scene = sheet +
                          "material = \"silk\"\n"
                          "[[obstacle]]\nname = \"floor\"\nmaterial = \"wood\"\n"
                          "shape = { type = \"plane\", size = [9, 9] }\n"
                          "[[obstacle]]\nname = \"post\"\n"
                          "shape = { type = \"sphere\", radius = 0.1, resolution = [5] }\n"
                          "[material.silk]\n[material.wood]\n";

std::string pair(const std::string& names, const std::string& numbers = "friction = 0.3\n") {
  return scene + "[[contact.pair]]\nbetween = [" + names + "]\n" + numbers;
}

std::vector<BadCase> bad_pairs() {
  return {
      {"unknown_name", pair("\"sheet\", \"flor\""),
       R"(case.toml:15:21: no body, obstacle or material "flor"
  did you mean "floor"?)"},
      {"unknown_material", pair("\"silk\", \"wod\""),
       R"(case.toml:15:20: no body, obstacle or material "wod"
  did you mean "wood"?)"},
      {"body_and_material", pair("\"sheet\", \"wood\""),
       R"(case.toml:15:11: "wood" is a material, and "sheet" is none
  expected two bodies or obstacles, or two materials)"},
      {"two_obstacles", pair("\"floor\", \"post\""),
       R"(case.toml:15:11: a pair of two obstacles
  expected a body as one of the two: obstacles do not collide with each other)"},
      {"pair_twice",
       pair("\"sheet\", \"floor\"") +
           "[[contact.pair]]\nbetween = [\"floor\", \"sheet\"]\nfriction = 0.2\n",
       R"(case.toml:18:11: a second pair of "floor" and "sheet"
  expected each pair once)"},
      {"materials_twice",
       pair("\"silk\", \"silk\"") +
           "[[contact.pair]]\nbetween = [\"silk\", \"silk\"]\nfriction = 0.2\n",
       R"(case.toml:18:11: a second pair of "silk" and "silk"
  expected each pair once)"},
      {"restitution_of_cloth", pair("\"sheet\", \"floor\"", "friction = 0.3\nrestitution = 0.5\n"),
       R"(case.toml:17:15: a restitution in the pair of "sheet" and "floor"
  expected "friction" only: cloth has no restitution of its own; how it rebounds follows from its stiffness, its damping and contact.damping_time)"},
      {"no_friction", pair("\"sheet\", \"floor\"", ""),
       R"(case.toml:15:11: the pair of "sheet" and "floor" has no "friction"
  expected a number >= 0)"},
      {"negative_friction", pair("\"sheet\", \"floor\"", "friction = -0.3\n"),
       R"(case.toml:16:12: "friction" is -0.3
  expected a number >= 0)"},
      {"name_of_both", pair("\"sheet\", \"floor\"") + "[material.sheet]\n",
       R"(case.toml:15:12: "sheet" is the name of a material and of a body or obstacle
  expected different names, so that it is clear which of them the pair means)"},
      {"unknown_material_of_an_obstacle",
       scene + "[[obstacle]]\nname = \"table\"\nmaterial = \"wodo\"\n"
               "shape = { type = \"plane\", size = [9, 9] }\n",
       R"(case.toml:16:12: unknown material "wodo"
  did you mean "wood"?)"},
      {"empty_material_of_an_obstacle",
       scene + "[[obstacle]]\nname = \"table\"\nmaterial = \"\"\n"
               "shape = { type = \"plane\", size = [9, 9] }\n",
       R"(case.toml:16:12: "material" is ""
  expected a name of letters, digits, _ and -)"},
  };
}

class BadContactPair : public testing::TestWithParam<BadCase> {};

TEST_P(BadContactPair, IsRefused) { expect_refused(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Cases, BadContactPair, testing::ValuesIn(bad_pairs()), bad_case_name);

}  // namespace
}  // namespace weft::sim::bad_contact_pair_test
