// Materials and obstacles from included files: what they become, and which files are refused.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <ostream>

#include "sim/case/case_reader.h"
#include "sim/run/make_simulation.h"
#include "tests/temporary_folder.h"

namespace weft::sim::include_case_test {

namespace {

using Files = std::map<std::string, std::string>;  // path -> text

const std::string sheet = R"([[body]]
name = "sheet"
position = [0, 0, 0.12]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [9, 9] }
)";

const std::string cotton = R"([material.cotton]
density = 0.15
membrane_stiffness = 500
)";

const std::string ball = R"([[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [9] }
)";

std::string include(const std::string& path) { return "[[include]]\npath = \"" + path + "\"\n"; }

class CaseFiles {
 public:
  explicit CaseFiles(const Files& files) {
    for (const auto& [path, text] : files) {
      std::filesystem::create_directories((folder_.path() / path).parent_path());
      folder_.write(path, text);
    }
  }
  std::string path(const std::string& name) const { return folder_.path(name); }
  Case read(const std::vector<std::string>& overrides = {}) const {
    return read_case(path("case.toml"), overrides);
  }
  // Returns the message of the error, with paths relative to the folder.
  std::string fault(const std::vector<std::string>& overrides = {}) const {
    try {
      read(overrides);
    } catch (const CaseError& error) {
      std::string text = error.what();
      const std::string prefix = folder_.path().string() + '/';
      for (std::size_t at = 0; (at = text.find(prefix)) != std::string::npos;) {
        text.erase(at, prefix.size());
      }
      return text;
    }
    return "accepted";
  }

 private:
  TemporaryFolder folder_;
};

// A case in three files, each in a folder of its own.
CaseFiles nested() {
  return CaseFiles({{"case.toml", include("library/room.toml") + sheet},
                    {"library/room.toml", include("materials/cotton.toml") + ball},
                    {"library/materials/cotton.toml", cotton}});
}

}  // namespace

TEST(CaseInclude, GivesTheSameCaseAsOneFile) {
  const Case whole = parse_case(cotton + sheet + ball, "case.toml");
  const Case merged = nested().read();
  EXPECT_EQ(merged.resolved_text, whole.resolved_text);
  EXPECT_EQ(merged.resolved_text.find("include"), std::string::npos);
  EXPECT_EQ(parse_case(merged.resolved_text, "alone.toml").resolved_text, whole.resolved_text);
}

TEST(CaseInclude, GivesTheSameBitsAsOneFile) {
  Simulation whole = make_simulation(parse_case(cotton + sheet + ball, "case.toml"));
  Simulation merged = make_simulation(nested().read());
  for (Simulation* each : {&whole, &merged}) {
    if (const auto failure = each->advance(0.08)) ADD_FAILURE() << failure->text;
  }
  EXPECT_GT(whole.contact_pairs(), 0U);
  EXPECT_EQ(merged.position("sheet"), whole.position("sheet"));
  EXPECT_EQ(merged.velocity("sheet"), whole.velocity("sheet"));
}

TEST(CaseInclude, PutsObstaclesAfterThoseOfTheIncludingFile) {
  const auto box = [](const std::string& name) {
    return "[[obstacle]]\nname = \"" + name +
           "\"\nshape = { type = \"sphere\", radius = 1, resolution = [3] }\n";
  };
  const CaseFiles files({{"case.toml", include("a.toml") + include("b.toml") + sheet + box("own")},
                         {"a.toml", include("c.toml") + box("a")},
                         {"b.toml", box("b")},
                         {"c.toml", box("c")}});
  std::string names;
  for (const ObstacleCase& each : files.read().obstacle) names += each.name + ' ';
  EXPECT_EQ(names, "own a c b ");
}

TEST(CaseInclude, KeepsTheFileAndLineOfEveryTable) {
  const CaseFiles files = nested();
  const Case read = files.read();
  EXPECT_EQ(read.obstacle[0].location.file, files.path("library/room.toml"));
  EXPECT_EQ(read.obstacle[0].location.line, 3);
  EXPECT_EQ(read.body[0].location.file, files.path("case.toml"));
}

TEST(CaseInclude, OverridesReachIncludedTables) {
  const Case read = nested().read({"material.cotton.density=0.3", "material.cotton.mass_damping=2",
                                   "obstacle.ball.shape.radius=0.05"});
  EXPECT_EQ(read.material[0].density, 0.3);
  EXPECT_EQ(read.material[0].mass_damping.constant(), 2.0);
  EXPECT_EQ(read.material[0].membrane_stiffness, 500.0);
  EXPECT_EQ(read.obstacle[0].shape.radius, 0.05);
}

TEST(CaseInclude, OverridesChooseTheFile) {
  const CaseFiles files({{"case.toml", include("cotton.toml") + sheet},
                         {"cotton.toml", cotton},
                         {"silk.toml", "[material.silk]\ndensity = 0.07\n"}});
  EXPECT_EQ(files.read().body[0].material, "cotton");
  EXPECT_EQ(
      files.read({"material.silk.density=0.08", "include.0.path=silk.toml"}).material[0].density,
      0.08);
}

TEST(CaseInclude, FindsShapesBesideTheIncludedFile) {
  const std::string scan = R"([[obstacle]]
name = "scan"
shape = { type = "file", path = "data/scan.h5", dataset = "x" }
)";
  const CaseFiles files({{"case.toml", include("a/room.toml") + sheet},
                         {"a/room.toml", include("../b/scan.toml")},
                         {"b/scan.toml", scan},
                         {"b/data/scan.h5", "not read here"}});
  const Case read = files.read();
  EXPECT_EQ(read.obstacle[0].shape.path, "a/../b/data/scan.h5");
  // The resolved case names the same file from the place of the case.
  EXPECT_EQ(parse_case(read.resolved_text, files.path("alone.toml")).resolved_text,
            read.resolved_text);
}

TEST(CaseInclude, MergesAFileOnce) {
  const CaseFiles files(
      {{"case.toml", include("a.toml") + include("b.toml") + include("./a.toml") + sheet},
       {"a.toml", include("cotton.toml")},
       {"b.toml", include("cotton.toml") + ball},
       {"cotton.toml", cotton}});
  const Case read = files.read();
  EXPECT_EQ(read.material.size(), 1U);
  EXPECT_EQ(read.obstacle.size(), 1U);
}

struct BadInclude {
  std::string name;
  Files files;
  std::string what;  // the whole message
  std::vector<std::string> overrides = {};
};

std::ostream& operator<<(std::ostream& stream, const BadInclude& bad) { return stream << bad.name; }

// Returns a case that includes "part.toml" with this text.
Files with_part(const std::string& part) {
  return {{"case.toml", include("part.toml") + sheet}, {"part.toml", part}};
}

std::vector<BadInclude> bad_includes() {
  return {
      {"no_such_file",
       {{"case.toml", include("materials/coton.toml") + sheet}},
       R"(case.toml:2:8: "materials/coton.toml" cannot be read: No such file or directory
  expected a TOML file with materials and obstacles, here materials/coton.toml)"},
      {"no_such_file_of_an_included_file",
       {{"case.toml", include("a/part.toml") + sheet}, {"a/part.toml", "\n" + include("b.toml")}},
       R"(a/part.toml:3:8: "b.toml" cannot be read: No such file or directory
  expected a TOML file with materials and obstacles, here a/b.toml)"},
      {"no_such_file_by_override",
       with_part(cotton),
       R"(--set include.0.path=silk.toml: "silk.toml" cannot be read: No such file or directory
  expected a TOML file with materials and obstacles, here silk.toml)",
       {"include.0.path=silk.toml"}},
      {"folder",
       {{"case.toml", include("a") + sheet}, {"a/part.toml", cotton}},
       R"(case.toml:2:8: "a" is a directory
  expected a TOML file with materials and obstacles, here a)"},
      {"path_missing",
       {{"case.toml", "[[include]]\n" + sheet}},
       R"(case.toml:1:1: [[include]] has no "path"
  expected "path", a string)"},
      {"path_of_wrong_type",
       {{"case.toml", "[[include]]\npath = 3\n" + sheet}},
       R"(case.toml:2:8: "path" is a whole number
  expected a string)"},
      {"unknown_key_of_include",
       {{"case.toml", "[[include]]\nfile = \"a.toml\"\n" + sheet}},
       R"(case.toml:2:1: unknown key "file" in [[include]]
  expected "path")"},
      {"include_without_table",
       {{"case.toml", "include = \"a.toml\"\n" + sheet}},
       R"(case.toml:1:11: "include" is a string
  expected tables [[include]])"},
      {"not_toml", with_part("[material.cotton]\ndensity =\n"),
       R"(part.toml:2:10: not TOML: Error while parsing key-value pair
  expected value, saw '\n')"},
      {"table_of_the_case", with_part(cotton + "[time]\nduration = 2\n"),
       R"(part.toml:4:2: "time" does not belong in an included file
  expected it in the case file; an included file holds [material.NAME], [[obstacle]] and [[include]])"},
      {"body", with_part(sheet),
       R"(part.toml:1:3: "body" does not belong in an included file
  expected it in the case file; an included file holds [material.NAME], [[obstacle]] and [[include]])"},
      {"unknown_table", with_part("[materail.cotton]\n"),
       R"(part.toml:1:2: unknown key "materail" in an included file
  did you mean "material"?)"},
      {"unknown_key", with_part("[material.cotton]\ndensitty = 1\n"),
       R"(part.toml:2:1: unknown key "densitty" in [material.cotton]
  did you mean "density"?)"},
      {"impossible_value", with_part("[material.cotton]\n  density = -1\n"),
       R"(part.toml:2:13: "density" is -1
  expected a number > 0 (kg/m^2))"},
      {"material_of_wrong_type", with_part("material = 3\n"),
       R"(part.toml:1:12: "material" is a whole number
  expected tables [material.NAME])"},
      {"obstacle_of_wrong_type", with_part("[obstacle]\nname = \"ball\"\n"),
       R"(part.toml:1:1: "obstacle" is a table
  expected tables [[obstacle]])"},
      {"rule_broken_in_an_included_file", with_part(R"([[obstacle]]
name = "ring"
shape = { type = "torus", major_radius = 1, minor_radius = 2, resolution = [9, 9] }
)"),
       R"(part.toml:3:60: minor_radius is 2 m
  expected less than major_radius, 1 m)"},
      {"shape_file_missing",
       {{"case.toml", include("a/part.toml") + sheet}, {"a/part.toml", R"([[obstacle]]
name = "scan"
shape = { type = "file", path = "scan.h5", dataset = "x" }
)"}},
       R"(a/part.toml:3:33: no file "a/scan.h5"
  expected an HDF5 file, here a/scan.h5)"},
      {"material_twice",
       {{"case.toml", include("part.toml") + cotton + sheet}, {"part.toml", "\n" + cotton}},
       R"(part.toml:2:11: a second [material.cotton]
  expected a name that no other material has; the first is at case.toml:3:11)"},
      {"material_in_two_includes",
       {{"case.toml", include("a.toml") + include("b.toml") + sheet},
        {"a.toml", cotton},
        {"b.toml", cotton}},
       R"(b.toml:1:11: a second [material.cotton]
  expected a name that no other material has; the first is at a.toml:1:11)"},
      {"obstacle_twice",
       {{"case.toml", include("part.toml") + sheet + ball}, {"part.toml", ball}},
       R"(part.toml:2:8: a second "ball"
  expected a name that no other body, obstacle or particles have; the first is in [[obstacle]], case.toml:8:8)"},
      {"obstacle_named_as_a_body",
       with_part("[[obstacle]]\nname = \"sheet\"\n"
                 "shape = { type = \"sphere\", radius = 1, resolution = [3] }\n"),
       R"(part.toml:2:8: a second "sheet"
  expected a name that no other body, obstacle or particles have; the first is in [[body]], case.toml:4:8)"},
      {"circle",
       {{"case.toml", include("a/x.toml") + sheet},
        {"a/x.toml", include("../b.toml")},
        {"b.toml", cotton + include("a/x.toml")}},
       R"(a/../b.toml:5:8: the includes form a circle
  expected files that do not include each other: a/x.toml -> a/../b.toml -> a/../a/x.toml)"},
      {"circle_through_the_case", with_part(include("case.toml")),
       R"(part.toml:2:8: the includes form a circle
  expected files that do not include each other: case.toml -> part.toml -> case.toml)"},
      {"override_of_a_missing_material",
       with_part(cotton),
       R"(--set material.coton.density=1: the case has no "material.coton"
  did you mean "cotton"?)",
       {"material.coton.density=1"}},
  };
}

class BadIncludes : public testing::TestWithParam<BadInclude> {};

TEST_P(BadIncludes, AreRefusedAtTheirPlace) {
  EXPECT_EQ(CaseFiles(GetParam().files).fault(GetParam().overrides), GetParam().what);
}

INSTANTIATE_TEST_SUITE_P(CaseInclude, BadIncludes, testing::ValuesIn(bad_includes()),
                         [](const auto& each) { return each.param.name; });

TEST(CaseInclude, RefusesLongChains) {
  Files files{{"case.toml", include("0.toml") + sheet}};
  for (int i = 0; i < 40; ++i) {
    files[std::to_string(i) + ".toml"] = include(std::to_string(i + 1) + ".toml");
  }
  EXPECT_EQ(CaseFiles(files).fault(), R"(30.toml:2:8: more than 32 files in each other
  expected a few levels of [[include]])");
}

}  // namespace weft::sim::include_case_test
