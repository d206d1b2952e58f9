// weft check --picture and --fix-initial.
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>
#include <string>

#include "sim/command/run_command.h"
#include "tests/sim/weft_process.h"
#ifndef WEFT_WITHOUT_GPU
#include <png.h>
#endif

namespace weft::sim::command_check_test {
namespace {

constexpr const char* crossed_sheets = R"(
time.duration = 0.02
[[body]]
name = "lower"
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [9, 9] }
[[body]]
name = "upper"
position = [0.013, 0.021, 0.004]
rotation_deg = [5, 3, 0]
stretch = [1.0, 0.99, 1.0]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [9, 9] }
)";

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

using CommandCheck = WeftCommand;

// Returns the arguments of the --set options that the command prints.
std::vector<std::string> printed_overrides(const std::string& out) {
  std::vector<std::string> overrides;
  const std::string opening = "  --set ";
  for (std::size_t at = out.find(opening); at != std::string::npos; at = out.find(opening, at)) {
    at += opening.size();
    std::string text = out.substr(at, out.find('\n', at) - at);
    std::erase(text, '\'');  // as a shell does
    overrides.push_back(text);
  }
  return overrides;
}

TEST_F(CommandCheck, FixInitialWritesANewShapeFileFromWhichTheCaseStarts) {
  write("crossed.toml", crossed_sheets);
  ASSERT_EQ(weft({"check", "crossed.toml"}).code, exit_code::bad_case);
  const Result fixed = weft({"check", "crossed.toml", "--fix-initial", "new/start.h5"});
  ASSERT_EQ(fixed.code, exit_code::done) << fixed.err;
  EXPECT_TRUE(holds(fixed.out, "vertices moved, by ")) << fixed.out;
  EXPECT_TRUE(exists("new/start.h5"));
  EXPECT_EQ(read_bytes(path("crossed.toml")), crossed_sheets);

  std::vector<std::string> arguments{"check", "crossed.toml"};
  for (const std::string& text : printed_overrides(fixed.out)) {
    arguments.push_back("--set");
    arguments.push_back(text);
  }
  ASSERT_GT(arguments.size(), 2U) << fixed.out;
  const Result checked = weft(arguments);
  EXPECT_EQ(checked.code, exit_code::done) << checked.err;
  arguments[0] = "run";
  arguments.push_back("--quiet");
  const Result run = weft(arguments);
  EXPECT_EQ(run.code, exit_code::done) << run.err;
}

// The printed path serves from the folder of the case, and ".." in it leads above the target of a
// link.
TEST_F(CommandCheck, FixInitialNamesFilesAcrossLinks) {
  std::filesystem::create_directories(path("store/cases"));
  std::filesystem::create_directory(path("project"));
  std::filesystem::create_directory_symlink("../store/cases", path("project/cases"));
  write("store/cases/crossed.toml", crossed_sheets);
  for (const std::string shapes : {"project/cases/../start.h5", "project/start.h5"}) {
    const Result fixed = weft({"check", "project/cases/crossed.toml", "--fix-initial", shapes});
    ASSERT_EQ(fixed.code, exit_code::done) << fixed.err;
    std::vector<std::string> arguments{"check", "project/cases/crossed.toml"};
    for (const std::string& text : printed_overrides(fixed.out)) {
      arguments.push_back("--set");
      arguments.push_back(text);
    }
    ASSERT_GT(arguments.size(), 2U) << fixed.out;
    const Result checked = weft(arguments);
    EXPECT_EQ(checked.code, exit_code::done) << checked.err;
    std::filesystem::remove(path(shapes));
  }
}

// The files that a run writes are its trajectory, the sidecar of that and the checkpoint, whose
// file has another name until it is complete.
TEST_F(CommandCheck, ARunNeverOverwritesTheShapesOfItsCase) {
  write("crossed.toml", crossed_sheets);
  for (const std::string shapes : {"out/crossed.h5", "out/crossed.xdmf", "out/crossed.checkpoint",
                                   "out/crossed.checkpoint.tmp"}) {
    const Result fixed = weft({"check", "crossed.toml", "--fix-initial", shapes});
    ASSERT_EQ(fixed.code, exit_code::done) << fixed.err;
    const std::string before = read_bytes(path(shapes));
    for (const std::string how : {"--force", "--resume"}) {
      std::vector<std::string> arguments{"run", "crossed.toml", "--quiet", how};
      for (const std::string& text : printed_overrides(fixed.out)) {
        arguments.push_back("--set");
        arguments.push_back(text);
      }
      const Result run = weft(arguments);
      EXPECT_EQ(run.code, exit_code::bad_case) << shapes << ' ' << how;
      EXPECT_TRUE(holds(run.err, shapes + ": the case reads this file, which weft run never"))
          << run.err;
      EXPECT_EQ(read_bytes(path(shapes)), before) << shapes << ' ' << how;
    }
    std::filesystem::remove_all(path("out"));
  }
}

TEST_F(CommandCheck, FixInitialOverwritesNothingWithoutForce) {
  write("crossed.toml", crossed_sheets);
  write("start.h5", "mine");
  const Result refused = weft({"check", "crossed.toml", "--fix-initial", "start.h5"});
  EXPECT_EQ(refused.code, exit_code::input_output);
  EXPECT_TRUE(holds(refused.err, "start.h5: exists already")) << refused.err;
  EXPECT_EQ(read_bytes(path("start.h5")), "mine");
  EXPECT_EQ(weft({"check", "crossed.toml", "--fix-initial", "start.h5", "--force"}).code,
            exit_code::done);
  EXPECT_NE(read_bytes(path("start.h5")), "mine");

  const Result own = weft({"check", "crossed.toml", "--fix-initial", "crossed.toml", "--force"});
  EXPECT_EQ(own.code, exit_code::bad_case);
  EXPECT_EQ(read_bytes(path("crossed.toml")), crossed_sheets);
}

// A new file would take the place of what reads and writes there.
TEST_F(CommandCheck, FixInitialReplacesNoPipe) {
  write("crossed.toml", crossed_sheets);
  ASSERT_EQ(mkfifo(path("start.h5").c_str(), 0600), 0);
  const Result refused = weft({"check", "crossed.toml", "--fix-initial", "start.h5", "--force"});
  EXPECT_EQ(refused.code, exit_code::input_output);
  EXPECT_TRUE(holds(refused.err, "start.h5: is no file")) << refused.err;
  EXPECT_TRUE(std::filesystem::is_fifo(path("start.h5")));
}

TEST_F(CommandCheck, FixInitialWritesNothingIfItCannotRepair) {
  write("crossed.toml", crossed_sheets);
  const Result deep = weft({"check", "crossed.toml", "--fix-initial", "start.h5", "--set",
                            "body.upper.rotation_deg=[30, 0, 0]"});
  EXPECT_EQ(deep.code, exit_code::bad_case);
  EXPECT_TRUE(deep.err.starts_with("crossed.toml: the initial state is not repaired: "))
      << deep.err;
  const Result apart = weft({"check", "crossed.toml", "--fix-initial", "start.h5", "--set",
                             "body.upper.position=[0, 0, 0.2]"});
  EXPECT_EQ(apart.code, exit_code::done) << apart.err;
  EXPECT_TRUE(holds(apart.out, "nothing to repair")) << apart.out;
  const Result without = weft(
      {"check", "crossed.toml", "--fix-initial", "start.h5", "--set", "contact.enabled=false"});
  EXPECT_EQ(without.code, exit_code::bad_case);
  for (const auto& entry : std::filesystem::directory_iterator(folder()))
    EXPECT_FALSE(holds(entry.path().filename(), "start.h5")) << entry.path();
}

constexpr const char* sheet_and_balls = R"(
time.duration = 0.02
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [9, 9] }
[[particles]]
name = "balls"
radius = 0.03
density = 100
positions = { type = "grid", count = [2, 2, 1], spacing = 0.1, centre = [0, 0, 0.1] }
)";

// Particles are never moved, so that a start in which they overlap something is not called whole.
TEST_F(CommandCheck, FixInitialRefusesParticlesThatOverlap) {
  write("balls.toml", sheet_and_balls);
  const Result apart = weft({"check", "balls.toml", "--fix-initial", "start.h5"});
  EXPECT_EQ(apart.code, exit_code::done) << apart.err;
  EXPECT_TRUE(holds(apart.out, "nothing to repair")) << apart.out;
  const Result in_sheet = weft({"check", "balls.toml", "--fix-initial", "start.h5", "--set",
                                "particles.balls.positions.centre=[0, 0, 0.02]"});
  EXPECT_EQ(in_sheet.code, exit_code::bad_case);
  EXPECT_TRUE(holds(in_sheet.err, "overlaps")) << in_sheet.err;
  EXPECT_FALSE(holds(in_sheet.out, "nothing to repair")) << in_sheet.out;

  const std::string alone(sheet_and_balls);
  write("alone.toml", alone.substr(0, alone.find("[[body]]")) +
                          alone.substr(alone.find("[[particles]]")) + R"([[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
)");
  for (const char* method : {"cvode", "impulses"}) {
    const std::string by = std::string("time.method=") + method;
    const Result above = weft({"check", "alone.toml", "--fix-initial", "start.h5", "--set", by});
    EXPECT_EQ(above.code, exit_code::done) << above.err;
    EXPECT_TRUE(holds(above.out, "nothing to repair")) << above.out;
    const Result in_floor = weft({"check", "alone.toml", "--fix-initial", "start.h5", "--set", by,
                                  "--set", "particles.balls.positions.centre=[0, 0, 0.02]"});
    EXPECT_EQ(in_floor.code, exit_code::bad_case);
    EXPECT_TRUE(holds(in_floor.err, "overlaps obstacle \"floor\"")) << in_floor.err;
  }
  EXPECT_FALSE(exists("start.h5"));
}

TEST_F(CommandCheck, SpheresThatTouchOverlapByNothing) {
  write("balls.toml", sheet_and_balls);
  const Result touching = weft({"check", "balls.toml", "--set", "body.sheet.thickness=0.0625",
                                "--set", "particles.balls.radius=0.03125", "--set",
                                "particles.balls.positions.centre=[0, 0, 0.0625]"});
  EXPECT_EQ(touching.code, exit_code::bad_case);
  EXPECT_TRUE(holds(touching.err, " touches ")) << touching.err;
}

#ifndef WEFT_WITHOUT_GPU
// Returns the number of pixels whose colour (red, green, blue) is accepted; -1 if there is no
// picture.
template <class Accepts>
int count_pixels(const std::string& path, const Accepts& accepts) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return -1;
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(image));
  png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr);
  int count = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3)
    count += accepts(rgb[i], rgb[i + 1], rgb[i + 2]) ? 1 : 0;
  return count;
}

// Returns the number of pixels in the red of intersections.
int red_pixels(const std::string& path) {
  return count_pixels(path, [](int red, int green, int blue) {
    return red > 140 && green < 0.4 * red && blue < 0.4 * red;
  });
}

// Balls are bluish and darker than the background, beside a red sheet. The area that they cover
// grows with the square of their radius.
TEST_F(CommandCheck, PictureShowsParticles) {
  write("balls.toml", sheet_and_balls);
  const auto blue_pixels = [&](const std::string& radius) {
    const Result drawn = weft({"check", "balls.toml", "--force", "--picture", "balls.png", "--set",
                               "particles.balls.radius=" + radius});
    EXPECT_EQ(drawn.code, exit_code::done) << drawn.err;
    return count_pixels(path("balls.png"),
                        [](int red, int, int blue) { return red < 190 && blue > red + 4; });
  };
  const int small = blue_pixels("0.015"), large = blue_pixels("0.03");
  EXPECT_GT(small, 200);
  EXPECT_NEAR(large, 4.0 * small, 0.4 * large);
}

// Particles that overlap another one, a sheet or an obstacle are red.
TEST_F(CommandCheck, PictureShowsOverlappingParticles) {
  write("balls.toml", sheet_and_balls);
  const std::string alone(sheet_and_balls);
  write("alone.toml", alone.substr(0, alone.find("[[body]]")) +
                          alone.substr(alone.find("[[particles]]")) + R"([[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[[particles]]
name = "guest"
radius = 0.02
density = 100
positions = { type = "grid", count = [1, 1, 1], spacing = 0.1, centre = [0.05, 0.05, 0.3] }
)");
  const std::array<double, 9> places{0, 0, 0.1, 0.059, 0, 0.1, 0.12, 0, 0.1};
  const std::array<hsize_t, 2> extent{3, 3};
  const hid_t file = H5Fcreate(path("places.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t space = H5Screate_simple(2, extent.data(), nullptr);
  const hid_t dataset =
      H5Dcreate2(file, "places", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, places.data()), 0);
  H5Dclose(dataset);
  H5Sclose(space);
  H5Fclose(file);
  const auto said = [&](std::vector<std::string> arguments, const std::string& count) {
    arguments.insert(arguments.begin(), "check");
    arguments.insert(arguments.end(), {"--picture", "balls.png", "--force"});
    const Result drawn = weft(arguments);
    EXPECT_EQ(drawn.code, count.empty() ? exit_code::done : exit_code::bad_case) << drawn.err;
    const std::string text = "; " + count + " in red\n";
    EXPECT_EQ(holds(drawn.out, text), !count.empty()) << drawn.out;
    return red_pixels(path("balls.png"));
  };
  const std::string centre = "particles.balls.positions.centre=", set = "--set";
  const int plain = said({"balls.toml"}, "");
  EXPECT_GT(said({"balls.toml", set, centre + "[0, 0, 0.02]"}, "4 overlapping particles,"),
            plain + 2000);
  for (const std::string method : {"impulses", "cvode"}) {
    const auto with = [&](const std::string& override) {
      return std::vector<std::string>{"alone.toml", set, "time.method=" + method, set, override};
    };
    EXPECT_LT(said(with("title=apart"), ""), 100) << method;
    EXPECT_GT(said(with(centre + "[0, 0, 0.02]"), "4 overlapping particles,"), 2000) << method;
    // The guest overlaps one ball, and of the places in the file two are too near each other.
    EXPECT_GT(said(with("particles.guest.positions.centre=[0.05, 0.05, 0.14]"),
                   "2 overlapping particles,"),
              2000)
        << method;
    EXPECT_GT(said(with("particles.balls.positions={ type = \"file\", path = \"places.h5\", "
                        "dataset = \"places\" }"),
                   "2 overlapping particles,"),
              2000)
        << method;
  }
}

// Drawing computes in float32, whose range squares of such coordinates leave.
TEST_F(CommandCheck, PictureOfAnImmenseOrTinyStartIsRefused) {
  write("crossed.toml", crossed_sheets);
  for (const char* start :
       {"body.upper.position=[1e60, 0, 0]", "body.upper.position=[0, 1e20, 0]"}) {
    const Result far = weft({"check", "crossed.toml", "--picture", "start.png", "--set", start});
    EXPECT_EQ(far.code, exit_code::input_output) << start;
    EXPECT_TRUE(holds(far.err, "cannot draw what is not finite")) << far.err;
  }
  const Result tiny =
      weft({"check", "crossed.toml", "--picture", "start.png", "--set",
            "body.lower.shape.size=[1e-24, 1e-24]", "--set", "body.upper.shape.size=[1e-24, 1e-24]",
            "--set", "body.upper.position=[0, 0, 0]"});
  EXPECT_EQ(tiny.code, exit_code::input_output);
  EXPECT_TRUE(holds(tiny.err, "seen from less than 1e-18 m")) << tiny.err;
  EXPECT_FALSE(std::filesystem::exists(path("start.png")));
}

TEST_F(CommandCheck, PictureShowsTheIntersections) {
  write("crossed.toml", crossed_sheets);
  const Result crossed = weft({"check", "crossed.toml", "--picture", "crossed.png"});
  EXPECT_EQ(crossed.code, exit_code::bad_case);
  EXPECT_TRUE(holds(crossed.err, "intersecting pairs of triangles, at")) << crossed.err;
  EXPECT_TRUE(holds(crossed.out, "picture crossed.png: ")) << crossed.out;
  const Result apart = weft({"check", "crossed.toml", "--picture", "apart.png", "--set",
                             "body.upper.position=[0, 0, 0.2]"});
  EXPECT_EQ(apart.code, exit_code::done) << apart.err;
  EXPECT_TRUE(holds(apart.out, "0 intersecting pairs")) << apart.out;
  EXPECT_GT(red_pixels(path("crossed.png")), red_pixels(path("apart.png")) + 2000);

  const Result twice = weft(
      {"check", "crossed.toml", "--picture", "new.png", "--fix-initial", "./new.png", "--force"});
  EXPECT_EQ(twice.code, exit_code::bad_case);
  EXPECT_TRUE(holds(twice.err, "new.png is the file of --fix-initial, too")) << twice.err;
  EXPECT_FALSE(exists("new.png"));

  write("mine.png", "mine");
  const Result foreign = weft({"check", "crossed.toml", "--picture", "mine.png"});
  EXPECT_EQ(foreign.code, exit_code::input_output);
  EXPECT_EQ(read_bytes(path("mine.png")), "mine");
  const Result own = weft({"check", "crossed.toml", "--picture", "crossed.toml", "--force"});
  EXPECT_EQ(own.code, exit_code::bad_case);
  EXPECT_TRUE(holds(own.err, "the case reads this file, which --picture never changes")) << own.err;
  EXPECT_EQ(read_bytes(path("crossed.toml")), crossed_sheets);
  EXPECT_EQ(weft({"check", "crossed.toml", "--picture", "crossed.png"}).code, exit_code::bad_case);
  std::filesystem::create_directory(path("parts"));
  const std::string wool = "[material.wool]\n";
  write("parts/wool.toml", wool);
  write("wool.toml", std::string(crossed_sheets) + "[[include]]\npath = \"parts/wool.toml\"\n");
  const Result part = weft({"check", "wool.toml", "--picture", "parts/wool.toml", "--force"});
  EXPECT_EQ(part.code, exit_code::bad_case);
  EXPECT_TRUE(holds(part.err, "the case reads this file, which --picture never changes"))
      << part.err;
  EXPECT_EQ(read_bytes(path("parts/wool.toml")), wool);
}
#endif

}  // namespace
}  // namespace weft::sim::command_check_test
