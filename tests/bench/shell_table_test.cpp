// The table of `weft bench shells`: it has a row for everything that shells and cloth must show.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "bench/table_part.h"

namespace weft::bench::shell_table_test {
namespace {

std::vector<std::string> check_names() {
  std::vector<std::string> names;
  for (const TablePart& part : table_parts())
    names.insert(names.end(), part.checks.begin(), part.checks.end());
  return names;
}

// Names of checks, or their beginnings up to a comma.
const std::vector<std::string>& demanded() {
  static const std::vector<std::string> all{
      "rolled plate, cloth",
      "rolled plate, woven cloth",
      "rolled plate, measured cloth",
      "rolled plate, cubic shell",
      "rolled plate, quadratic shell",
      "cantilever, end shear",
      "cantilever, end moment",
      "hemisphere with hole, full load",
      "hemisphere with hole, linear",
      "hemisphere of 2 x 2 patches",
      "Scordelis-Lo roof",
      "pinched cylinder",
      "heavy elastica, Gamma = 1",
      "heavy elastica, Gamma = 10",
      "heavy elastica, Gamma = 100",
      "heavy elastica, Gamma = 1000",
      "square plate, ssss, six modes",
      "square plate, cccc, six modes",
      "square plate, cscs, six modes",
      "square plate, ffff, six modes",
      "square plate, buckling",
      "cloth cantilever",
      "Delingette springs against St. Venant-Kirchhoff",
      "spring lattice",
      "spring lattice, extrapolated",
      "strain limit under 10 x weight",
      "loss factor from a ring-down",
      "crease angle after unloading",
      "hinged roof, limit load",
      "hinged roof, pushed against arc length",
      "slit annular plate",
      "open cylinder pulled apart",
      "narrow strip buckling sideways",
      "shell dropped on a sphere",
      "shell dropped on a sphere, cost",
      "shell dropped on cloth",
      "shell dropped on cloth, cost",
      "multigrid iterations",
      "memory per vertex",
      "hemisphere, full load: CalculiX / Weft",
      "pinched cylinder: CalculiX / Weft",
  };
  return all;
}

const std::vector<std::string>& fabrics() {
  static const std::vector<std::string> all{
      "ivory-rib-knit",    "pink-ribbon-brown", "white-dots-on-blk", "navy-sparkle-sweat",
      "camel-ponte-roma",  "gray-interlock",    "11oz-black-denim",  "white-swim-solid",
      "tango-red-jet-set", "royal-target"};
  return all;
}

TEST(ShellTable, HasEveryCheck) {
  const std::vector<std::string> names = check_names();
  const auto is_there = [&](const std::string& text) {
    return std::ranges::any_of(names, [&](const std::string& name) {
      return name == text || name.starts_with(text + ", ");
    });
  };
  for (const std::string& text : demanded()) EXPECT_TRUE(is_there(text)) << text;
  for (const std::string& fabric : fabrics()) {
    EXPECT_TRUE(is_there("uniaxial stretch, " + fabric)) << fabric;
    EXPECT_TRUE(is_there("uniaxial pull, free sides, " + fabric)) << fabric;
    EXPECT_TRUE(is_there("biaxial stretch, " + fabric)) << fabric;
  }
}

TEST(ShellTable, NamesAreUnique) {
  const std::vector<std::string> names = check_names();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
}

// Whatever the demand, a row has all fields; those that do not apply are null.
TEST(ShellTable, RowsHaveAllFields) {
  for (const Bound bound :
       {Bound::none, Bound::error, Bound::at_most, Bound::wanted, Bound::reported}) {
    CheckRow row{.check = "a", .resolution = {4, 5}, .quantity = "b"};
    row.value = 3;
    row.reference = row.scale = 2;
    row.bound = bound;
    row.limit = 0.1;
    row.source = "c";
    const nlohmann::json json = json_of(row);
    for (const char* field : {"check", "case", "resolution", "quantity", "value", "reference",
                              "error", "limit", "cpu_s", "source"})
      EXPECT_TRUE(json.contains(field)) << field;
    EXPECT_EQ(json["value"], 3);
    EXPECT_EQ(json["reference"].is_null(), bound == Bound::reported);
    const bool has_error = bound != Bound::reported && bound != Bound::wanted;
    EXPECT_EQ(json["error"].is_null(), !has_error);
    if (has_error) {
      EXPECT_EQ(json["error"], 0.5);
    }
    EXPECT_EQ(json["limit"].is_null(), bound != Bound::error && bound != Bound::at_most);
  }
}

TEST(ShellTable, LimitsAreKept) {
  CheckRow row{.reference = 2, .scale = 2, .bound = Bound::error, .limit = 0.1};
  row.value = 2.1;
  EXPECT_TRUE(row.holds());
  row.value = 1.7;
  EXPECT_FALSE(row.holds());
  row.bound = Bound::at_most;
  EXPECT_TRUE(row.holds());
  EXPECT_EQ(row.error(), 0);
  row.value = 2.01;
  EXPECT_FALSE(row.holds());
  row.failure = "it fell apart";
  row.bound = Bound::reported;
  EXPECT_FALSE(row.holds());
}

TEST(ShellTable, ChecksAreChosenByTheirNames) {
  EXPECT_TRUE(is_wanted("spring lattice", {}));
  EXPECT_TRUE(is_wanted("spring lattice", {"roof", "lattice"}));
  EXPECT_FALSE(is_wanted("spring lattice", {"roof"}));
}

// Cheap parts, as a run of the whole table makes them.
TEST(ShellTable, PartsMakeTheirRows) {
  int rows = 0;
  for (const TablePart& part : table_parts()) {
    if (part.case_name != "triangle_springs" && part.case_name != "spring_lattice" &&
        part.case_name != "scordelis_lo" && part.checks[0] != "biaxial stretch, royal-target")
      continue;
    part.run([&](const CheckRow& row) {
      ++rows;
      EXPECT_TRUE(row.failure.empty()) << row.failure;
      EXPECT_TRUE(row.holds()) << row.check << ": " << row.error();
      EXPECT_FALSE(row.source.empty());
      EXPECT_NE(std::ranges::find(part.checks, row.check), part.checks.end()) << row.check;
    });
  }
  EXPECT_EQ(rows, 1 + 4 + 2 + 4 + 1);
}

}  // namespace
}  // namespace weft::bench::shell_table_test
