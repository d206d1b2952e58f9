#include "sim/case/case_reader.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/case/case_checks.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"
#include "sim/case/case_writer.h"
#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::case_reader_test {

namespace {

constexpr const char* drape = R"(title = "A sheet draped over a torus"

[time]
duration = 2
frames_per_second = 30

[material.cotton]
density = 0.15
membrane_stiffness = 500

[[body]]
name = "sheet"
position = [0, 0, 1]

[body.shape]
type = "rectangle"
size = [2.0, 1.5]
resolution = [65, 33]

[[body.pin]]
corners = ["first_first", "first_last"]

[[body.pin]]
rows = [-1, -1]
cols = [0, 3]
motion = { velocity = [0, 0, 0.5], stop_time = 1 }

[[obstacle]]
name = "torus"
shape = { type = "torus", major_radius = 0.6, minor_radius = 0.2, resolution = [64, 32] }
)";

constexpr const char* least = R"([[body]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [8] }
)";

// Uses every key except those that rule others out.
constexpr const char* everything = R"(title = "quotes \" and \\ and\nlines, \u00e9"
[time]
duration = 0.30000000000000004
velocity_tolerance = 1e-4
maximum_order = 4
position_tolerance = 1e-7
maximum_step = 0.1
[contact]
search_slack = 0.01
[output]
velocity = true
[compute]
threads = 3
backend = "cpu"
cpu_limit = 1e4
[material.springy]
membrane = "springs"
structural_stiffness = 12
shear_stiffness = 6.5
bend_stiffness = 0
stiffness_damping = 1e-4
[material.stiff]
bending_stiffness = 1e300
mass_damping = 4.9e-324
[[body]]
name = "tube"
material = "springy"
self_contact = false
shape = { type = "cylinder", radius = 0.1, length = 1, resolution = [2, 3] }
[[body.pin]]
edges = ["first_row"]
region_min = [-1, -1, -1]
region_max = [1, 1, 1]
[body.pin.motion]
centre = [0, 0, 0.5]
[[body.pin.motion.keyframes]]
time = 0
[[body.pin.motion.keyframes]]
time = 1.5
translation = [0, 0, 1]
rotation_deg = [0, 90, 0]
[[body]]
name = "scan"
material = "stiff"
shape = { type = "file", path = "scan.h5", dataset = "a/b", wrap_u = true }
[[body.pin]]
corners = ["all"]
patch = 12
[[obstacle]]
name = "ball"
thickness = 0
shape = { type = "sphere", radius = 1, resolution = [4] }
motion = { angular_velocity_deg = [0, 0, 90], start_time = 0.25 }
)";

// Calls `visit(path, field)` for every field of a description, lists by their entries.
void for_each_field(const Table& table, const std::string& path,
                    const std::function<void(const std::string&, const Field&)>& visit) {
  for (const Field& field : table.fields) {
    const std::string inner = join_path(path, field.key);
    visit(inner, field);
    if (const auto* member = std::get_if<TableMember>(&field.member)) {
      if (member->present()) for_each_field(member->open(), inner, visit);
    } else if (const auto* list = std::get_if<TableList>(&field.member)) {
      for (std::size_t i = 0; i < list->size(); ++i) {
        for_each_field(list->at(i), join_path(inner, i), visit);
      }
    }
  }
}

// Every value of a case by its path.
std::map<std::string, std::string> values_of(Case target) {
  std::map<std::string, std::string> values;
  for_each_field(describe(target), "", [&](const std::string& path, const Field& field) {
    values[path] = value_text(field);
  });
  return values;
}

// A case with one entry in every list and every table present.
Case full_prototype() {
  Case prototype;
  prototype.time.method = TimeMethod::static_loads;  // which [static] goes with
  const auto fill = [](const Table& table, const auto& self) -> void {
    for (const Field& field : table.fields) {
      if (const auto* member = std::get_if<TableMember>(&field.member)) {
        self(member->open(), self);
      } else if (const auto* list = std::get_if<TableList>(&field.member)) {
        self(list->append(), self);
      }
    }
  };
  fill(describe(prototype), fill);
  prototype.material[0].name = "NAME";
  return prototype;
}

}  // namespace

// Pins of an equilibrium have no times, but the text of the case has their default.
TEST(CaseReader, ReadsBackPinsOfEquilibria) {
  const Case read = parse_case(R"([time]
method = "static"
[contact]
enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[[body.pin]]
corners = ["last_first", "last_last"]
)",
                               "sheet.toml");
  EXPECT_EQ(parse_case(read.resolved_text, "sheet.toml").resolved_text, read.resolved_text);
}

TEST(CaseReader, ReadsWhatIsWritten) {
  const Case read = parse_case(drape, "drape.toml");
  EXPECT_EQ(read.title, "A sheet draped over a torus");
  EXPECT_EQ(read.path, "drape.toml");
  EXPECT_EQ(read.time.duration, 2.0);
  EXPECT_EQ(read.time.frames_per_second, 30.0);
  ASSERT_EQ(read.material.size(), 1U);
  EXPECT_EQ(read.material[0].name, "cotton");
  EXPECT_EQ(read.material[0].density, 0.15);
  EXPECT_EQ(read.material[0].membrane_stiffness, 500.0);
  ASSERT_EQ(read.body.size(), 1U);
  EXPECT_EQ(read.body[0].position, Vec3(0, 0, 1));
  EXPECT_EQ(read.body[0].shape.type, ShapeType::rectangle);
  EXPECT_EQ(read.body[0].shape.size, (std::vector<double>{2.0, 1.5}));
  EXPECT_EQ(read.body[0].shape.resolution, (std::vector<int>{65, 33}));
  ASSERT_EQ(read.body[0].pin.size(), 2U);
  EXPECT_EQ(read.body[0].pin[0].vertices.corners,
            (std::vector<std::string>{"first_first", "first_last"}));
  EXPECT_FALSE(read.body[0].pin[0].motion);
  EXPECT_EQ(read.body[0].pin[1].vertices.rows, (std::vector<int>{-1, -1}));
  ASSERT_TRUE(read.body[0].pin[1].motion);
  EXPECT_EQ(read.body[0].pin[1].motion->velocity, Vec3(0, 0, 0.5));
  EXPECT_EQ(read.body[0].pin[1].motion->stop_time, 1.0);
  ASSERT_EQ(read.obstacle.size(), 1U);
  EXPECT_EQ(read.obstacle[0].shape.type, ShapeType::torus);
  EXPECT_EQ(read.obstacle[0].shape.minor_radius, 0.2);
}

TEST(CaseReader, KnowsWhereTablesStand) {
  const Case read = parse_case(drape, "drape.toml");
  EXPECT_EQ(read.body[0].location.file, "drape.toml");
  EXPECT_EQ(read.body[0].location.line, 11);
  EXPECT_EQ(read.body[0].location.column, 1);
  EXPECT_EQ(read.body[0].shape.location.line, 15);
  EXPECT_EQ(read.body[0].pin[1].location.line, 23);
  EXPECT_EQ(read.body[0].pin[1].motion->location.line, 26);
  EXPECT_EQ(read.body[0].pin[1].motion->location.column, 10);
  EXPECT_EQ(read.obstacle[0].location.line, 28);
}

TEST(CaseReader, LeavesTheRestAsTheStructsHaveIt) {
  Case expected;
  expected.material.emplace_back().name = "default";
  BodyCase& ball = expected.body.emplace_back();
  ball.name = "ball";
  ball.material = "default";
  ball.shape.type = ShapeType::sphere;
  ball.shape.radius = 0.1;
  ball.shape.resolution = {8};
  EXPECT_EQ(values_of(parse_case(least, "least.toml")), values_of(expected));
}

TEST(CaseReader, GivesBodiesTheOnlyMaterial) {
  EXPECT_EQ(parse_case(drape, "drape.toml").body[0].material, "cotton");
}

TEST(CaseReader, ReadsFilesRelativeToTheCase) {
  const TemporaryFolder folder;
  folder.write("scan.h5", "not read here");
  const std::string path = folder.write("case.toml", everything);
  const Case read = read_case(path);
  EXPECT_EQ(read.path, path);
  EXPECT_EQ(read.title, "quotes \" and \\ and\nlines, \u00e9");
  EXPECT_EQ(read.body[1].shape.path, "scan.h5");
  EXPECT_TRUE(read.body[1].shape.wrap_u);
  EXPECT_EQ(read.material[0].membrane, MembraneModel::springs);
  EXPECT_EQ(read.material[0].bend_stiffness, 0.0);
  ASSERT_EQ(read.body[0].pin[0].motion->keyframes.size(), 2U);
  EXPECT_EQ(read.body[0].pin[0].motion->keyframes[1].rotation_deg, Vec3(0, 90, 0));
}

TEST(CaseReader, ResolvedTextReadsBackTheSame) {
  const TemporaryFolder folder;
  folder.write("scan.h5", "not read here");
  const std::string path = folder.write("case.toml", "");
  for (const char* text : {drape, least, everything}) {
    const Case first = parse_case(text, path, {"world.air_density=0.1", "contact.friction=0.25"});
    const Case second = parse_case(first.resolved_text, path);
    EXPECT_EQ(values_of(first), values_of(second));
    EXPECT_EQ(first.resolved_text, second.resolved_text);
    EXPECT_NE(first.resolved_text.find("friction = 0.25\n"), std::string::npos);
    EXPECT_NE(first.resolved_text.find("relative_tolerance = 1e-04\n"), std::string::npos);
  }
}

TEST(CaseReader, AllowsTheToleranceOfTheDefaultRange) {
  // Up to rounding, 1e-5 m is 0.005 of 2e-3 m: the limit itself is allowed.
  EXPECT_NO_THROW(parse_case(std::string("time.velocity_tolerance = 1e-3\n") + least, "a.toml"));
  EXPECT_NO_THROW(parse_case(least, "a.toml", {"contact.enabled=false", "contact.range=1e-6"}));
}

TEST(CaseOverride, ReachesEveryKindOfPlace) {
  const Case read = parse_case(
      drape, "drape.toml",
      {"title=Over a ring # 2", "time.duration=0.5", "contact.friction=0.3",
       "world.gravity.2=-1.62", "material.cotton.membrane=springs",
       "material.cotton.bend_stiffness=2", "body.sheet.thickness=2e-3", "body.0.position=[1, 2, 3]",
       "body.sheet.position.0=4", "body.sheet.pin.0.corners.1=last_last",
       "body.sheet.pin.1.motion.velocity=[1, 0, 0]", "body.sheet.pin.0.motion.start_time=0.5",
       "obstacle.torus.shape.minor_radius=0.1", "obstacle.torus.name=ring"});
  EXPECT_EQ(read.title, "Over a ring # 2");
  EXPECT_EQ(read.time.duration, 0.5);
  EXPECT_EQ(read.contact.friction.constant(), 0.3);
  EXPECT_EQ(read.material[0].membrane, MembraneModel::springs);
  EXPECT_EQ(read.material[0].bend_stiffness, 2.0);
  EXPECT_EQ(read.body[0].thickness, 2e-3);
  EXPECT_EQ(read.body[0].position, Vec3(4, 2, 3));
  EXPECT_EQ(read.body[0].pin[0].vertices.corners[1], "last_last");
  EXPECT_EQ(read.body[0].pin[1].motion->velocity, Vec3(1, 0, 0));
  EXPECT_EQ(read.body[0].pin[0].motion->start_time, 0.5);
  EXPECT_EQ(read.obstacle[0].shape.minor_radius, 0.1);
  EXPECT_EQ(read.obstacle[0].name, "ring");
}

TEST(CaseOverride, LaterOnesWin) {
  const Case read = parse_case(least, "a.toml", {"time.duration=2", "time.duration=3"});
  EXPECT_EQ(read.time.duration, 3.0);
}

TEST(CaseOverride, StringsMayLookLikeSomethingElse) {
  EXPECT_EQ(parse_case(least, "a.toml", {"title=2024"}).title, "2024");
  EXPECT_EQ(parse_case(least, "a.toml", {"title=\"quoted\""}).title, "quoted");
  EXPECT_EQ(parse_case(least, "a.toml", {"title=a=b"}).title, "a=b");
  EXPECT_EQ(parse_case(least, "a.toml", {"title="}).title, "");
}

TEST(CaseOverride, NamesWinOverIndices) {
  const std::string two = std::string(least) + R"([[body]]
name = "0"
shape = { type = "sphere", radius = 0.1, resolution = [8] }
)";
  const Case read = parse_case(two, "a.toml", {"body.0.thickness=0.5", "body.1.position.0=1"});
  EXPECT_EQ(read.body[0].thickness, BodyCase{}.thickness);
  EXPECT_EQ(read.body[1].thickness, 0.5);
}

TEST(CaseOverride, ChangesTheMaterialOfDefaults) {
  EXPECT_EQ(parse_case(least, "a.toml", {"material.default.density=0.5"}).material[0].density, 0.5);
}

TEST(CaseSchema, CoversEveryKey) {
  const auto schema = nlohmann::json::parse(case_json_schema());
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  Case prototype = full_prototype();
  std::map<std::string, int> keys;  // by table
  for_each_field(describe(prototype), "", [&](const std::string& path, const Field& field) {
    // "body[0].pin[0].rows" is at body/items/properties/pin/items/properties/rows; tables with
    // names are not items.
    const std::string entries = path.starts_with("material") ? "/additionalProperties" : "/items";
    std::string pointer = "/properties/";
    for (const char c : path) {
      if (c == '[') pointer += entries;
      if (c == '.') pointer += "/properties/";
      if (std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_') pointer += c;
    }
    const std::size_t dot = path.rfind('.');
    ++keys[dot == std::string::npos ? "" : path.substr(0, dot)];
    const auto at = nlohmann::json::json_pointer(pointer);
    ASSERT_TRUE(schema.contains(at)) << pointer;
    EXPECT_EQ(schema[at]["description"], field.meaning);
    EXPECT_TRUE(schema[at].contains("type") || schema[at].contains("enum") ||
                schema[at].contains("anyOf"))
        << pointer;
    EXPECT_FALSE(field.meaning.empty());
  });
  const std::map<std::string, int> expected{
      {"", 17},
      {"time", 15},
      {"static", 7},
      {"world", 3},
      {"contact", 10},
      {"contact.pair[0]", 3},
      {"output", 10},
      {"output.part[0]", 4},
      {"compute", 4},
      {"restart", 2},
      {"include[0]", 1},
      {"material[0]", 27},
      {"material[0].orthotropic_membrane", 7},
      {"material[0].orthotropic_membrane.warp_curve", 2},
      {"material[0].orthotropic_membrane.weft_curve", 2},
      {"material[0].orthotropic_membrane.shear_curve", 2},
      {"material[0].measured_membrane", 5},
      {"material[0].orthotropic_bending", 5},
      {"body[0]", 14},
      {"body[0].shape", 17},
      {"body[0].start", 3},
      {"body[0].start.shape", 17},
      {"body[0].pin[0]", 13},
      {"body[0].pin[0].motion", 6},
      {"body[0].pin[0].motion.keyframes[0]", 3},
      {"obstacle[0]", 7},
      {"obstacle[0].shape", 17},
      {"obstacle[0].motion", 6},
      {"obstacle[0].motion.keyframes[0]", 3},
      {"tie[0]", 11},
      {"seam[0]", 12},
      {"load[0]", 13},
      {"particles[0]", 10},
      {"particles[0].positions", 11},
  };
  EXPECT_EQ(keys, expected);
}

TEST(CaseSchema, HasTheFormsOfWhatVaries) {
  const auto schema = nlohmann::json::parse(case_json_schema());
  const auto& world = schema["properties"]["world"]["properties"];
  EXPECT_EQ(world["wind"]["anyOf"].size(), 3U);
  EXPECT_EQ(world["gravity"]["anyOf"].size(), 2U);
  EXPECT_EQ(world["gravity"]["default"], nlohmann::json({0.0, 0.0, -9.81}));
  EXPECT_EQ(world["wind"]["anyOf"][0]["type"], "array");
  EXPECT_EQ(world["wind"]["anyOf"][2]["required"],
            nlohmann::json({"mean", "intensity", "time_scale"}));
  const auto& friction =
      schema["properties"]["contact"]["properties"]["friction"]["anyOf"][1]["properties"];
  EXPECT_EQ(friction["values"]["items"]["minimum"], 0.0);
  EXPECT_EQ(friction["times"]["items"]["minimum"], 0.0);
  EXPECT_EQ(friction["between"]["enum"], nlohmann::json({"linear", "smooth", "step"}));
  const auto& values = world["wind"]["anyOf"][1]["properties"]["values"]["items"];
  EXPECT_EQ(values["minItems"], 3);
}

TEST(CaseSchema, SaysWhatTheReaderChecks) {
  const auto schema = nlohmann::json::parse(case_json_schema());
  const auto& time = schema["properties"]["time"];
  EXPECT_EQ(time["additionalProperties"], false);
  EXPECT_EQ(time["properties"]["duration"]["exclusiveMinimum"], 0.0);
  EXPECT_EQ(time["properties"]["duration"]["default"], 1.0);
  EXPECT_EQ(time["properties"]["duration"]["unit"], "s");
  EXPECT_EQ(time["properties"]["maximum_order"]["maximum"], 5.0);
  EXPECT_FALSE(schema.contains("required"));  // [[body]] or [[particles]]
  const auto& shape = schema["properties"]["body"]["items"]["properties"]["shape"];
  EXPECT_EQ(shape["required"], nlohmann::json({"type"}));
  EXPECT_EQ(shape["allOf"][0]["if"]["properties"]["type"]["const"], "rectangle");
  EXPECT_EQ(shape["allOf"][0]["then"]["required"], nlohmann::json({"size", "resolution"}));
  EXPECT_EQ(shape["allOf"][0]["then"]["properties"]["radius"], false);
}

TEST(CaseReference, NamesEveryKeyWithItsMeaning) {
  const std::string page = case_reference_markdown();
  Case prototype = full_prototype();
  for_each_field(describe(prototype), "", [&](const std::string& path, const Field& field) {
    EXPECT_NE(page.find("| `" + field.key + "` | "), std::string::npos) << path;
    EXPECT_NE(page.find(field.meaning), std::string::npos) << path;
  });
  for (const char* title : {"## `[time]`", "## `[material.NAME]`", "## `[[body]]`",
                            "## `[body.shape]`", "## `[[body.pin]]`", "## `[body.pin.motion]`",
                            "## `[[body.pin.motion.keyframes]]`", "## `[[obstacle]]`"}) {
    EXPECT_NE(page.find(title), std::string::npos) << title;
  }
}

// Runs are resumed from the resolved text, and run folders are named after it. It must not lose a
// key because the case lacks another one that excludes it.
TEST(CaseText, ResolvedPinsKeepTheirAxes) {
  const std::string pins = R"([[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
pin = [{ rows = [0, 0], axes = ["y", "z"] }, { edges = ["last_row"], clamp = true },
       { cols = [1, 1] }]
)";
  const std::string cloth = "[material.cloth]\nbending_stiffness = 1e-4\n";
  const Case source = parse_case(cloth + pins, "case.toml");
  const Case again = parse_case(source.resolved_text, "resolved.toml");
  EXPECT_EQ(again.resolved_text, source.resolved_text);
  ASSERT_EQ(again.body[0].pin.size(), 3U);
  const std::vector<PinCase>& pin = again.body[0].pin;
  EXPECT_EQ(pin[0].axes, (std::vector<std::string>{"y", "z"}));
  EXPECT_TRUE(pin[1].clamp);
  for (const int i : {1, 2}) EXPECT_TRUE(pin[i].axes.empty());
}

// Loads on areas are of all patches. Texts of older versions give them the first one.
TEST(CaseText, LoadsOnAreasHaveNoPatch) {
  const std::string text = R"([[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
pin = [{ rows = [0, 0], axes = ["y", "z"] }]
[[load]]
body = "sheet"
type = "pressure"
pressure = 1
[[load]]
body = "sheet"
type = "line"
force = [0, 0, 1]
edges = ["first_row"]
)";
  const std::string resolved = parse_case(text, "case.toml").resolved_text;
  EXPECT_EQ(parse_case(resolved, "resolved.toml").resolved_text, resolved);
  EXPECT_EQ(without_obsolete_keys(resolved), resolved);
  std::string older = resolved;
  const std::string pressure = "pressure = 1.0\n";
  older.insert(older.find(pressure) + pressure.size(), "patch = 0\n");
  EXPECT_THROW(parse_case(older, "older.toml"), CaseError);
  EXPECT_EQ(without_obsolete_keys(older), resolved);
}

TEST(CaseText, ResolvedCasesAreTheSameCases) {
  int cases = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(WEFT_CASES_DIR)) {
    if (entry.path().extension() != ".toml" || entry.path().parent_path().filename() == "materials")
      continue;
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.find("\n[factors") != std::string::npos) continue;  // a sweep
    SCOPED_TRACE(entry.path());
    const Case source = read_case(entry.path());
    EXPECT_EQ(parse_case(source.resolved_text, entry.path()).resolved_text, source.resolved_text);
    ++cases;
  }
  EXPECT_GT(cases, 30);
}

TEST(CaseText, NearestNameNeedsFewEdits) {
  const std::vector<std::string> names = {"rows", "resolution", "radius"};
  EXPECT_EQ(nearest_name("rwos", names), "rows");      // two neighbours swapped
  EXPECT_EQ(nearest_name("Radius", names), "radius");  // case
  EXPECT_EQ(nearest_name("resolutoin", names), "resolution");
  EXPECT_EQ(nearest_name("raddiuss", names), "radius");  // two of eight
  EXPECT_EQ(nearest_name("ra", names), std::nullopt);    // four of six
  EXPECT_EQ(nearest_name("", {}), std::nullopt);
}

TEST(CaseText, NumbersReadBackBitForBit) {
  for (const double value : {0.1, 1.0, 1e-5, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, -0.0}) {
    const double again = std::strtod(toml_number(value).c_str(), nullptr);
    EXPECT_EQ(std::signbit(again), std::signbit(value));
    EXPECT_EQ(again, value);
    EXPECT_NE(toml_number(value).find_first_of(".e"), std::string::npos);
  }
}

// Steps such as 0.0166667 are as long as the time between frames.
TEST(CaseReader, StepsLongerThanTheTimeBetweenFramesAreNoticed) {
  TimeCase time;
  time.frames_per_second = 60;
  for (const double step : {0.005, 1.0 / 60, 0.0166667}) {
    time.step = step;
    EXPECT_EQ(long_step_notice(time), "") << step;
  }
  time.step = 0.0167;
  EXPECT_NE(long_step_notice(time).find("is longer than the time between frames"),
            std::string::npos);
}

TEST(CaseReader, DevicesThatHaveNothingToSearchAreNoticed) {
  const auto notice = [](const std::string& backend, const std::string& more) {
    return idle_device_notice(
        parse_case(std::string(hanging_sheet) + more + "[compute]\nbackend = \"" + backend + "\"\n",
                   "test.toml", {"contact.enabled=true"}));
  };
  const std::string ball =
      "[[particles]]\nname = \"ball\"\nradius = 0.01\n"
      "positions = { type = \"grid\", count = [1, 1, 1], centre = [0, 0, 1] }\n";
  EXPECT_EQ(notice("gpu", ""), "");
  EXPECT_EQ(notice("cpu", ball), "");
  EXPECT_EQ(notice("gpu", ball),
            R"(compute.backend, "gpu", has no effect: the CPU searches particles)");
  EXPECT_EQ(
      idle_device_notice(parse_case(hanging_sheet, "test.toml", {R"(compute.backend="osmesa")"})),
      R"(compute.backend, "osmesa", has no effect: contact is off)");
}

}  // namespace weft::sim::case_reader_test
