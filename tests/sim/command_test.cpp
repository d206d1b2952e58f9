// The weft command as users meet it: arguments, messages, exit codes; all except runs.
#include <nlohmann/json.hpp>

#include "sim/case/case_reader.h"
#include "sim/command/run_command.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::command_test {
namespace {

constexpr const char* sheet_case = R"(title = "A sheet"
time.duration = 0.05
contact.enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 5] }
)";

// Two sheets that cross, an initial state that contact refuses.
constexpr const char* crossed_case = R"(
time.duration = 0.02
world.gravity = [0, 0, 0]
contact.enabled = false
[[body]]
name = "flat"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [3, 3] }
[[body]]
name = "upright"
position = [0.011, 0.013, 0.017]
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [3, 3] }
)";

using Command = WeftCommand;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(Command, SaysItsVersion) {
  const Result result = weft({"--version"});
  EXPECT_EQ(result.code, exit_code::done);
  EXPECT_EQ(result.out, "weft " WEFT_VERSION "\n");
  EXPECT_EQ(result.err, "");
}

TEST_F(Command, HelpNamesEveryCommandAndExitCode) {
  const Result result = weft({"--help"});
  EXPECT_EQ(result.code, exit_code::done);
  for (const char* word :
       {"weft run", "weft check", "weft modes", "weft buckling", "weft info", "weft render",
        "weft schema", "0 done", "1 numerical", "2 bad case", "4 input", "130", "143"}) {
    EXPECT_TRUE(contains(result.out, word)) << word << '\n' << result.out;
  }
  EXPECT_EQ(result.err, "");
  for (const char* command : {"run", "check", "modes", "buckling", "info", "render", "schema"}) {
    EXPECT_EQ(weft({command, "--help"}).code, exit_code::done) << command;
  }
}

TEST_F(Command, RefusesArgumentsItDoesNotKnow) {
  write("sheet.toml", sheet_case);
  struct Mistake {
    WeftProcess::Arguments arguments;
    std::string message;
  };
  const Mistake mistakes[] = {
      {{}, "Usage:"},
      {{"rnu", "sheet.toml"}, "\"rnu\" is unknown; did you mean \"run\"?"},
      {{"--verion"}, "did you mean \"--version\"?"},
      {{"run", "sheet.toml", "--froce"}, "\"--froce\" is unknown; did you mean \"--force\"?"},
      {{"run", "sheet.toml", "--outptu=there"}, "did you mean \"--output\"?"},
      {{"info", "sheet.h5", "--crossing"}, "did you mean \"--crossings\"?"},
      {{"sweep", "status", "out", "--quiet"}, "\"--quiet\" is unknown; expected one of"},
      {{"run", "sheet.toml", "--frobnicate"}, "\"--frobnicate\" is unknown; expected one of"},
      {{"run", "sheet.toml", "another.toml"}, "\"another.toml\" is unknown"},
      {{"run", "sheet.toml", "--set", "time.duration=1", "contact.friction=0"},
       "\"contact.friction=0\" is unknown; did you mean \"--set contact.friction=0\"?"},
      {{"run"}, "case is required"},
      {{"run", "sheet.toml", "-o", ""}, "--output: expected a name, not an empty text"},
      {{"run", "sheet.toml", "--restart-from", "", "--time", "1"},
       "--restart-from: expected a name, not an empty text"},
      {{"run", "sheet.toml", "--restart-from", "sheet.h5", "--time", "nan"},
       "--time: the time is not a finite number"},
      {{"modes", "sheet.toml", "-o", ""}, "--output: expected a name, not an empty text"},
      {{"check", "sheet.toml", "--picture", ""}, "--picture: expected a name, not an empty text"},
      {{"check", "sheet.toml", "--fix-initial", ""},
       "--fix-initial: expected a name, not an empty text"},
      {{"render", "sheet.h5", "-o", ""}, "--output: expected a name, not an empty text"},
      {{"sweep", "sheet.toml", "-o", ""}, "--output: expected a name, not an empty text"},
      {{"sweep", "work", "out", "--list", ""}, "--list: expected a name, not an empty text"},
      {{"render", "sheet.h5", "--every", "0"}, "--every"},
      {{"render", "sheet.h5", "--lod", "0"}, "\"0\" is not a number of pixels from 0.001 to 1000"},
      {{"render", "sheet.h5", "--lod", "nan"}, "\"nan\" is not a number of pixels"},
      {{"render", "sheet.h5", "--lod", "1px"}, "\"1px\" is not a number of pixels"},
      {{"render", "sheet.h5", "--colour", "velocity", "--bsi", "2"}, "--colour excludes --bsi"},
      {{"render", "sheet.h5", "--colour-range", "0,1"}, "--colour-range requires --colour"},
      {{"render", "sheet.h5", "--colour", "velocity", "--colour-range", "2,1"},
       "\"2,1\" is not a range: expected MIN,MAX, two numbers, the first one smaller"},
      {{"render", "sheet.h5", "--colour", "velocity", "--colour-range", "nan,1"},
       "\"nan,1\" is not a range"},
      {{"render", "sheet.h5", "--colour", "velocity", "--colour-range", "1"},
       "\"1\" is not a range"}};
  for (const Mistake& mistake : mistakes) {
    const Result result = weft(mistake.arguments);
    EXPECT_EQ(result.code, exit_code::bad_case) << mistake.message;
    EXPECT_TRUE(contains(result.err, mistake.message)) << mistake.message << "\n" << result.err;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_FALSE(exists("out"));
}

// The first case of a page, between its fences.
std::string case_of_page(const std::string& page, const std::string& heading) {
  const std::string text = read_bytes(WEFT_SOURCE_DIR + ("/" + page));
  const std::string opening = "```toml\n";
  const std::size_t start = text.find(opening, text.find(heading)) + opening.size();
  return text.substr(start, text.find("```", start) - start);
}

TEST_F(Command, TakesTheCasesOfItsPages) {
  write("towel.toml", case_of_page("docs/guide.md", "\n## From an idea to a case\n"));
  write("cloth.toml", case_of_page("README.md", "\nA case file of your own:\n"));
  for (const char* name : {"towel.toml", "cloth.toml"}) {
    const Result result = weft({"check", name});
    EXPECT_EQ(result.code, exit_code::done) << result.err;
    EXPECT_TRUE(contains(result.out, "\nforces    gravity, membrane, bending, drag\n"))
        << result.out;
  }
}

TEST_F(Command, RefusesABadCaseBeforeItWritesAnything) {
  write("bad.toml", "title = \"A misspelt key\"\n[time]\n  duratoin = 2.0\n");
  for (const char* command : {"run", "check"}) {
    const Result result = weft({command, "bad.toml"});
    EXPECT_EQ(result.code, exit_code::bad_case);
    EXPECT_TRUE(result.err.starts_with("bad.toml:3:3: ")) << result.err;
    EXPECT_TRUE(contains(result.err, "did you mean \"duration\"?")) << result.err;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_FALSE(exists("out"));
}

TEST_F(Command, RefusesAnInitialStateWithoutAGapBeforeItWritesAnything) {
  write("close.toml", std::string(sheet_case) + R"([[obstacle]]
name = "floor"
position = [0.0, 0.0, -0.0009]
thickness = 0.001
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
)");
  const Result result = weft({"run", "close.toml", "--set", "contact.enabled=true"});
  EXPECT_EQ(result.code, exit_code::bad_case);
  EXPECT_TRUE(result.err.starts_with("close.toml:7:1: ")) << result.err;
  EXPECT_TRUE(contains(result.err, "sheet") && contains(result.err, "floor")) << result.err;
  EXPECT_FALSE(exists("out"));
}

TEST_F(Command, RefusesCrossedSheetsBeforeItWritesAnything) {
  write("crossed.toml", crossed_case);
  const Result result = weft({"run", "crossed.toml", "--set", "contact.enabled=true"});
  EXPECT_EQ(result.code, exit_code::bad_case);
  EXPECT_TRUE(result.err.starts_with("crossed.toml:8:1: ")) << result.err;
  EXPECT_TRUE(contains(result.err, "intersecting pairs of triangles")) << result.err;
  EXPECT_TRUE(contains(result.err, "flat") && contains(result.err, "upright")) << result.err;
  EXPECT_TRUE(contains(result.err, "move the bodies apart")) << result.err;
  std::vector<std::string> places;
  std::istringstream lines(result.err);
  for (std::string line; std::getline(lines, line);)
    if (contains(line, "  with  ")) places.push_back(line);
  EXPECT_GT(places.size(), 1U);
  std::ranges::sort(places);
  EXPECT_EQ(std::ranges::adjacent_find(places), places.end()) << result.err;
  EXPECT_FALSE(exists("out"));
}

TEST_F(Command, RefusesAMissingCase) {
  const Result result = weft({"run", "nowhere.toml"});
  EXPECT_EQ(result.code, exit_code::bad_case);
  EXPECT_TRUE(contains(result.err, "nowhere.toml: cannot be read: No such file")) << result.err;
  EXPECT_FALSE(exists("out"));
}

TEST_F(Command, RefusesABadOverrideByName) {
  write("sheet.toml", sheet_case);
  for (const char* bad : {"time.duratoin=1", "time.duration=\"long\"", "time.duration"}) {
    const Result result = weft({"run", "sheet.toml", "--set", bad});
    EXPECT_EQ(result.code, exit_code::bad_case) << bad;
    EXPECT_TRUE(contains(result.err, std::string("--set ") + bad)) << result.err;
  }
  EXPECT_FALSE(exists("out"));
}

TEST_F(Command, CheckSaysWhatACaseNeedsAndSkips) {
  write("sheet.toml", sheet_case);
  const Result result = weft({"check", "sheet.toml", "--set", "body.sheet.thickness=0.0035"});
  EXPECT_EQ(result.code, exit_code::done);
  EXPECT_EQ(result.err, "");
  for (const char* part :
       {"A sheet", "sheet: 4 x 5 vertices, 24 triangles, thickness 3.5 mm", "gravity, membrane",
        "skipped bending: every bending_stiffness is 0", "skipped GL context"}) {
    EXPECT_TRUE(contains(result.out, part)) << part << '\n' << result.out;
  }
  EXPECT_FALSE(exists("out"));
}

TEST_F(Command, CheckSaysWhichRecordedBodiesAreWrittenOnce) {
  write("sheets.toml", crossed_case);
  const std::string once = ": it does not move and is written once";
  const std::string held = "body.flat.pin=[{rows=[0, -1]}]";
  const Result all = weft({"check", "sheets.toml", "--set", held});
  EXPECT_TRUE(contains(all.out, "skipped frames of flat" + once)) << all.out << all.err;
  const Result one =
      weft({"check", "sheets.toml", "--set", held, "--set", "output.bodies=['upright']"});
  EXPECT_EQ(one.code, exit_code::done) << one.err;
  EXPECT_FALSE(contains(one.out, once)) << one.out;
}

TEST_F(Command, InfoSummarisesATrajectory) {
  write("sheet.toml", sheet_case);
  ASSERT_EQ(weft({"run", "sheet.toml", "--quiet"}).code, exit_code::done);
  const Result text = weft({"info", "out/sheet.h5"});
  EXPECT_EQ(text.code, exit_code::done);
  EXPECT_TRUE(contains(text.out, "A sheet")) << text.out;
  EXPECT_TRUE(contains(text.out, "sheet: 4 x 5, 20 particles, 24 triangles")) << text.out;

  const Result result = weft({"info", "--json", "out/sheet.h5"});
  EXPECT_EQ(result.code, exit_code::done);
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("title"), "A sheet");
  EXPECT_EQ(json.at("frames"), 4);  // 0, 1/60, 2/60, 0.05 s
  EXPECT_EQ(json.at("last_time_s"), 0.05);
  EXPECT_EQ(json.at("bodies").at(0).at("name"), "sheet");
  EXPECT_EQ(json.at("bodies").at(0).at("particles"), 20);
}

TEST_F(Command, InfoCountsCrossings) {
  write("crossed.toml", crossed_case);
  write("sheet.toml", sheet_case);
  ASSERT_EQ(weft({"run", "crossed.toml", "--quiet"}).code, exit_code::done);
  ASSERT_EQ(weft({"run", "sheet.toml", "--quiet"}).code, exit_code::done);
  const Result text = weft({"info", "--crossings", "out/crossed.h5"});
  EXPECT_EQ(text.code, exit_code::done);
  EXPECT_TRUE(contains(text.out, "crossings, the first between flat")) << text.out;
  EXPECT_EQ(weft({"info", "--crossings", "out/sheet.h5"}).out, "0 crossings in 4 frames\n");

  const Result result = weft({"info", "--crossings", "--json", "out/crossed.h5"});
  const nlohmann::json json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json.at("frames").size(), 3U);
  int total = 0;
  for (const nlohmann::json& frame : json.at("frames")) {
    const int count = frame.at("count");
    EXPECT_GT(count, 0);
    EXPECT_EQ(frame.at("first").at(0).at("body"), "flat");
    total += count;
  }
  EXPECT_EQ(json.at("crossings"), total);
}

#ifdef WEFT_WITHOUT_GPU
constexpr bool can_render = false;
#else
constexpr bool can_render = true;
#endif

TEST_F(Command, InfoAndRenderRefuseWhatIsNoTrajectory) {
  write("text.h5", "not HDF5");
  for (const char* command : {"info", "render"}) {
    for (const char* file : {"nowhere.h5", "text.h5"}) {
      const Result result = weft({command, file});
      EXPECT_EQ(result.code, exit_code::input_output) << command << ' ' << file;
      const bool reads = can_render || std::string(command) == "info";
      EXPECT_TRUE(contains(result.err, reads ? file : "WEFT_GPU=ON")) << result.err;
      EXPECT_EQ(result.out, "");
    }
  }
}

TEST_F(Command, RenderPaintsAFieldOrNamesThoseThatAreThere) {
  if (!can_render) GTEST_SKIP() << "built without gpu/";
  write("sheet.toml", sheet_case);
  ASSERT_EQ(weft({"run", "sheet.toml", "--quiet", "--set", "output.velocity=true"}).code,
            exit_code::done);
  const Result unknown = weft({"render", "out/sheet.h5", "--colour", "velocty"});
  EXPECT_EQ(unknown.code, exit_code::bad_case);
  EXPECT_EQ(unknown.out, "");
  EXPECT_EQ(
      unknown.err,
      "out/sheet.h5: there is no field \"velocty\" in the file; did you mean \"velocity\"? It "
      "has \"velocity\"\n");
  EXPECT_FALSE(exists("pictures"));
  const Result painted = weft({"render", "out/sheet.h5", "--every", "1000", "--width", "240",
                               "--height", "180", "--colour", "velocity", "--colour-range", "0,9"});
  EXPECT_EQ(painted.code, exit_code::done) << painted.err;
  EXPECT_TRUE(contains(painted.out, "\ncoloured by velocity: 0 to ")) << painted.out;
  EXPECT_TRUE(contains(painted.out, " m/s, colours from 0 to 9\n")) << painted.out;
  EXPECT_TRUE(exists("pictures/frame_00000.png"));
}

// HDF5 1.10 loses memory at a wrong checksum and would complain of it at exit, as would the leak
// sanitizer.
TEST_F(Command, InfoSaysInOneLineThatAFileIsDamaged) {
  write("sheet.toml", sheet_case);
  ASSERT_EQ(weft({"run", "sheet.toml", "--quiet"}).code, exit_code::done);
  std::string bytes = read_bytes(path("out/sheet.h5"));
  const std::size_t header = bytes.find("OHDR");
  ASSERT_NE(header, std::string::npos);
  bytes[header + 24] = static_cast<char>(~bytes[header + 24]);
  write("damaged.h5", bytes);
  const Result result =
      weft({"info", "damaged.h5"}, [] { setenv("ASAN_OPTIONS", "detect_leaks=0", 1); });
  EXPECT_EQ(result.code, exit_code::input_output);
  EXPECT_TRUE(contains(result.err, "checksum")) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

TEST_F(Command, PrintsTheSchema) {
  const Result result = weft({"schema"});
  EXPECT_EQ(result.code, exit_code::done);
  EXPECT_EQ(result.out, case_json_schema());
  EXPECT_EQ(nlohmann::json::parse(result.out).at("type"), "object");
}

TEST_F(Command, PrintsTheReferencePageOfTheDocumentation) {
  const Result result = weft({"schema", "--markdown"});
  EXPECT_EQ(result.code, exit_code::done);
  EXPECT_EQ(result.out, read_bytes(WEFT_SOURCE_DIR "/docs/case_reference.md"));
}

TEST_F(Command, NoticesThatNobodyGotItsResults) {
  const auto to_full_device = [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); };
  const Result result = weft({"schema"}, to_full_device);
  EXPECT_EQ(result.code, exit_code::input_output);
  EXPECT_TRUE(contains(result.err, "standard output")) << result.err;
}

}  // namespace
}  // namespace weft::sim::command_test
