// Runs that begin in the state of another run.
#include "sim/run/restart.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/run/make_simulation.h"
#include "sim/run/recorded_run.h"
#include "sim/run/run_checkpoint.h"
#include "sim/scene/spline_surface.h"
#include "sim/scene/start_states.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::restart_test {
namespace {

// A sheet flies and turns, without any force but gravity.
constexpr const char* flying_sheet = R"(
[time]
duration = 0.1
frames_per_second = 100
[contact]
enabled = false
[output]
velocity = true
[material.cloth]
stiffness_damping = 1e-3
[[body]]
name = "sheet"
velocity = [1, 0, 2]
angular_velocity_deg = [0, 0, 90]
shape = { type = "rectangle", size = [0.2, 0.1], resolution = [5, 9] }
)";

class Restart : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }
  Case parse(const std::string& text, const Overrides& overrides = {}) const {
    return parse_case(text, path("test.toml"), overrides);
  }
  // Reads the case as a file of that name in the folder of the test.
  Case parse_as(const std::string& name, const std::string& text,
                const Overrides& overrides = {}) const {
    return parse_case(text, path(name), overrides);
  }
  void write(const std::string& name, const std::string& text) const { folder_.write(name, text); }
  // Writes a square of 5 x 5 vertices with sides of that length (m).
  void write_shape(const std::string& name, double side) const {
    std::vector<double> values;
    for (int row = 0; row < 5; ++row)
      for (int col = 0; col < 5; ++col)
        values.insert(values.end(), {0.25 * side * col, 0.25 * side * row, 0});
    const hid_t file = H5Fcreate(path(name).c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const std::array<hsize_t, 3> shape{5, 5, 3};
    const hid_t space = H5Screate_simple(3, shape.data(), nullptr);
    const hid_t dataset =
        H5Dcreate2(file, "p", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
              0);
    H5Dclose(dataset);
    H5Sclose(space);
    H5Fclose(file);
  }
  // Returns the time of the checkpoint as TOML.
  std::string checkpoint_time(const std::string& file) const {
    const auto checkpoint = read_checkpoint(path(file));
    EXPECT_TRUE(checkpoint) << file;
    return checkpoint ? number_text(checkpoint->reached) : "";
  }
  RunReport run(const std::string& file, const Case& source) const {
    RunOptions options;
    options.trajectory = path(file);
    options.force = true;
    return run_simulation(source, options);
  }
  static Overrides from(const std::string& file, const std::string& time, Overrides more = {}) {
    more.insert(more.end(), {"restart.path=\"" + file + "\"", "restart.time=" + time});
    return more;
  }
  // Returns the message of the refusal of a restart.
  std::string refusal(const std::string& text, const Overrides& overrides) const {
    return refusal_of(parse(text, overrides));
  }
  static std::string refusal_of(const Case& source) {
    try {
      make_simulation(source);
    } catch (const CaseError& error) {
      return error.what();
    }
    return "";
  }

 private:
  TemporaryFolder folder_;
};

// A linear function of the row and the column has its values at every resolution.
TEST(Resampled, KeepsLinearFunctions) {
  const bsi::Atlas from({{.rows = 3, .cols = 5}}), to({{.rows = 9, .cols = 7}});
  const auto value = [](double v, double u) { return Vec3(v, u, 2 * v - u); };
  std::vector<Vec3> values;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 5; ++col) values.push_back(value(row / 2.0, col / 4.0));
  }
  const std::vector<Vec3> there = resampled(values, from, to);
  for (int row = 0; row < 9; ++row) {
    for (int col = 0; col < 7; ++col)
      EXPECT_LT((there[row * 7 + col] - value(row / 8.0, col / 6.0)).norm(), 1e-15);
  }
  EXPECT_EQ(resampled(values, from, from), values);
}

// On a closed axis the last texel lies before the first.
TEST(Resampled, ClosesImages) {
  const bsi::Atlas from({{.rows = 2, .cols = 4, .wrap_u = true}});
  const bsi::Atlas to({{.rows = 2, .cols = 8, .wrap_u = true}});
  std::vector<Vec3> values;
  for (int row = 0; row < 2; ++row) {
    for (const double u : {0.0, 1.0, 2.0, 1.0}) values.push_back(Vec3(u, row, 0));
  }
  const std::vector<Vec3> there = resampled(values, from, to);
  const std::vector<double> expected{0, 0.5, 1, 1.5, 2, 1.5, 1, 0.5};
  for (int col = 0; col < 8; ++col) EXPECT_EQ(there[col].x(), expected[col]);
}

// Points of a bent shell lie on its surface of splines at any resolution, not on the chords between
// its points.
TEST(Resampled, BendsShellsWithoutKinks) {
  const double radius = 0.5, angle = 2;
  const auto image_of = [&](const bsi::Atlas& atlas) {
    std::vector<Vec3> image;
    const bsi::Patch& patch = atlas.patches()[0];
    for (int row = 0; row < patch.rows; ++row) {
      for (int col = 0; col < patch.cols; ++col) {
        const double turn = angle * col / (patch.cols - 1);
        image.push_back(
            {radius * std::sin(turn), 0.1 * row / (patch.rows - 1), radius * std::cos(turn)});
      }
    }
    return image;
  };
  const bsi::Atlas from({{.rows = 4, .cols = 9}}), to({{.rows = 7, .cols = 33}});
  const SplineSurface surface(to, 3);
  const std::vector<Vec3> there = resampled(image_of(from), from, to, surface),
                          exact = image_of(to), chords = resampled(image_of(from), from, to);
  double farthest = 0, sagitta = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    farthest = std::max(farthest, (there[i] - exact[i]).norm());
    sagitta = std::max(sagitta, (chords[i] - exact[i]).norm());
  }
  EXPECT_GT(sagitta, 3e-3);
  EXPECT_LT(farthest, 0.02 * sagitta);
  const SplineSurface same(from, 3);
  EXPECT_EQ(resampled(image_of(from), from, from, same), image_of(from));
}

TEST_F(Restart, BeginsInAFrame) {
  ASSERT_EQ(run("first.h5", parse(flying_sheet)).status, RunReport::Status::done);
  ASSERT_EQ(run("second.h5", parse(flying_sheet, from("first.h5", "0.05"))).status,
            RunReport::Status::done);
  const TrajectoryReader first(path("first.h5")), second(path("second.h5"));
  EXPECT_EQ(second.time(0), 0);
  EXPECT_EQ(second.positions(0, 0), first.positions(0, 5));
  EXPECT_EQ(second.velocities(0, 0), first.velocities(0, 5));
  // The motion goes on: 0.05 s later it is where the first run is, within ten steps' tolerance.
  const std::vector<Vec3> one = first.positions(0, 10), other = second.positions(0, 5);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_LT((one[i] - other[i]).norm(), 1e-4) << i;
}

// A checkpoint has all bits of the state, and needs no recorded velocities.
TEST_F(Restart, BeginsInACheckpoint) {
  const Overrides exact{"output.velocity=false", "output.precision=\"float64\"",
                        "time.method=\"euler\"", "time.step=0.004"};
  ASSERT_EQ(run("first.h5", parse(flying_sheet, exact)).status, RunReport::Status::done);
  const auto checkpoint = read_checkpoint(path("first.h5"));
  ASSERT_TRUE(checkpoint);
  const TrajectoryReader first(path("first.h5"));
  ASSERT_EQ(first.time(first.frames() - 1), checkpoint->reached);
  const Simulation second = make_simulation(parse(flying_sheet, from("first.h5", "0.1", exact)));
  EXPECT_EQ(second.position("sheet"), first.positions(0, first.frames() - 1));
  const Vec3 mean_velocity = Vec3(1, 0, 2) - 0.1 * Vec3(0, 0, 9.81);
  Vec3 mean = Vec3::Zero();
  for (const Vec3& velocity : second.velocity("sheet")) mean += velocity / 45;
  EXPECT_LT((mean - mean_velocity).norm(), 1e-3);
}

// The image of the second run has other numbers of rows and columns, and passes through the same
// points.
TEST_F(Restart, ResamplesImages) {
  ASSERT_EQ(run("first.h5", parse(flying_sheet)).status, RunReport::Status::done);
  const Simulation second = make_simulation(
      parse(flying_sheet, from("first.h5", "0.05", {"body.sheet.shape.resolution=[9, 17]"})));
  const TrajectoryReader first(path("first.h5"));
  const std::vector<Vec3> coarse = first.positions(0, 5), fine = second.position("sheet");
  const std::vector<Vec3> slow = first.velocities(0, 5), fast = second.velocity("sheet");
  const bsi::Patch& patch = first.bodies()[0].atlas.patches()[0];
  const int cols = 2 * patch.cols - 1;
  for (int row = 0; row < patch.rows; ++row) {
    for (int col = 0; col < patch.cols; ++col) {
      EXPECT_EQ(fine[2 * row * cols + 2 * col], coarse[row * patch.cols + col]);
      EXPECT_EQ(fast[2 * row * cols + 2 * col], slow[row * patch.cols + col]);
    }
  }
}

// A sheet that lies on a ball, on an image so coarse that its triangles cut into the ball.
TEST_F(Restart, RefusesImagesThatCrossAnObstacle) {
  const std::string text = R"(
[time]
duration = 0.12
frames_per_second = 100
[output]
velocity = true
[material.cloth]
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.106]
velocity = [0, 0, -0.4]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [13, 13] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [9] }
)";
  ASSERT_EQ(run("first.h5", parse(text)).status, RunReport::Status::done);
  EXPECT_EQ(run("same.h5", parse(text, from("first.h5", "0.12", {"time.duration=0.01"}))).status,
            RunReport::Status::done);
  try {
    run("coarse.h5", parse(text, from("first.h5", "0.12", {"body.sheet.shape.resolution=[3, 3]"})));
    ADD_FAILURE() << "not refused";
  } catch (const CaseError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("\"sheet\""), std::string::npos) << message;
    EXPECT_NE(message.find("\"ball\""), std::string::npos) << message;
    EXPECT_NE(message.find("intersecting pairs of triangles"), std::string::npos) << message;
  }
  EXPECT_FALSE(std::filesystem::exists(path("coarse.h5")));
}

// A shell passes through the recorded points of its surface.
TEST_F(Restart, FitsShells) {
  const Overrides shell{"material.cloth.model=\"shell\"", "material.cloth.youngs_modulus=1e6",
                        "material.cloth.shell_thickness=1e-3", "material.cloth.volume_density=1000",
                        "output.precision=\"float64\""};
  ASSERT_EQ(run("first.h5", parse(flying_sheet, shell)).status, RunReport::Status::done);
  ASSERT_EQ(run("second.h5", parse(flying_sheet, from("first.h5", "0.05", shell))).status,
            RunReport::Status::done);
  const TrajectoryReader first(path("first.h5")), second(path("second.h5"));
  const std::vector<Vec3> one = first.positions(0, 5), other = second.positions(0, 0);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_LT((one[i] - other[i]).norm(), 1e-14) << i;
}

TEST_F(Restart, RefusesTimesWithoutAState) {
  run("first.h5", parse(flying_sheet));
  const auto checkpoint = read_checkpoint(path("first.h5"));
  ASSERT_TRUE(checkpoint);
  const std::string text = refusal(flying_sheet, from("first.h5", "0.054"));
  EXPECT_NE(text.find("first.h5 has no frame at t = 0.054 s\n  expected time = "),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("or the time of a frame; the nearest is 0.05"), std::string::npos) << text;
  run("plain.h5", parse(flying_sheet, {"output.velocity=false"}));
  const std::string plain = refusal(flying_sheet, from("plain.h5", "0.05"));
  EXPECT_NE(plain.find("the frames of body \"sheet\" have no velocities\n  expected time = "),
            std::string::npos)
      << plain;
  EXPECT_NE(plain.find("a trajectory with output.velocity = true"), std::string::npos) << plain;
}

TEST_F(Restart, RefusesOtherBodies) {
  run("first.h5", parse(flying_sheet));
  std::string other = flying_sheet;
  other.replace(other.find("\"sheet\""), 7, "\"sheat\"");
  const std::string name = refusal(other, from("first.h5", "0.05"));
  EXPECT_NE(name.find("has no body \"sheat\"\n  did you mean \"sheet\"?"), std::string::npos)
      << name;
  const std::string crease =
      refusal(flying_sheet,
              from("first.h5", "0.05",
                   {"material.cloth.bending_stiffness=1e-5", "material.cloth.yield_curvature=10"}));
  EXPECT_NE(crease.find("the creases of \"sheet\" are not part of a restart"), std::string::npos)
      << crease;
}

// Far from the origin, float32 positions are rounded by more than a hundredth of the gap.
TEST_F(Restart, RefusesGapsBelowTheRounding) {
  const std::string text = R"(
[time]
duration = 0.02
frames_per_second = 100
[output]
velocity = true
[[body]]
name = "sheet"
position = [1000, 0, 0.0015]
velocity = [0, 0, -0.05]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
[[obstacle]]
name = "floor"
position = [1000, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [3, 3] }
)";
  ASSERT_EQ(run("first.h5", parse(text)).status, RunReport::Status::done);
  const std::string refused = refusal(text, from("first.h5", "0"));
  EXPECT_NE(refused.find("has a smallest gap of "), std::string::npos) << refused;
  EXPECT_NE(refused.find("the checkpoint of"), std::string::npos) << refused;
  run("exact.h5", parse(text, {"output.precision=\"float64\""}));
  EXPECT_EQ(refusal(text, from("exact.h5", "0")), "");
}

// A sheet whose shape is in a file beside the case.
constexpr const char* sheet_of_file = R"(
[time]
duration = 0.02
method = "euler"
step = 1e-3
[contact]
enabled = false
[[body]]
name = "sheet"
velocity = [1, 0, 2]
shape = { type = "file", path = "shape.h5", dataset = "p" }
)";

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// A case in another folder finds the shape file of the run whose checkpoint it reads.
TEST_F(Restart, ReadsTheFilesOfTheOtherRunFromItsFolder) {
  write_shape("shape.h5", 0.1);
  run("first.h5", parse(sheet_of_file));
  const Overrides from_first = from("../first.h5", checkpoint_time("first.h5"));
  const Simulation here =
      make_simulation(parse(sheet_of_file, from("first.h5", checkpoint_time("first.h5"))));
  std::filesystem::create_directory(path("other"));
  Overrides shape{"body.sheet.shape.path=../shape.h5"};
  shape.insert(shape.end(), from_first.begin(), from_first.end());
  const Simulation there = make_simulation(parse_as("other/test.toml", sheet_of_file, shape));
  EXPECT_EQ(here.position("sheet"), there.position("sheet"));
  // The folders of the case and of the run may be moved together.
  std::filesystem::create_directory(path("moved"));
  for (const std::string name : {"shape.h5", "first.h5", "first.checkpoint"})
    std::filesystem::rename(path(name), path("moved/" + name));
  std::filesystem::create_directory(path("moved/other"));
  const Simulation moved = make_simulation(parse_as("moved/other/test.toml", sheet_of_file, shape));
  EXPECT_EQ(here.position("sheet"), moved.position("sheet"));
}

// Trajectories of earlier versions do not name the folder of their case.
TEST_F(Restart, ReadsTheFilesOfOlderRunsFromItsOwnFolder) {
  write_shape("shape.h5", 0.1);
  run("first.h5", parse(sheet_of_file));
  const hid_t file = H5Fopen(path("first.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(H5Adelete(file, "case_folder"), 0);
  H5Fclose(file);
  EXPECT_EQ(refusal(sheet_of_file, from("first.h5", checkpoint_time("first.h5"))), "");
}

TEST_F(Restart, NamesTheFileThatTheOtherRunNeeds) {
  write_shape("shape.h5", 0.1);
  run("first.h5", parse(sheet_of_file));
  std::filesystem::create_directory(path("other"));
  const Overrides overrides = from("../first.h5", checkpoint_time("first.h5"));
  std::filesystem::remove(path("shape.h5"));
  const std::string missing = refusal_of(parse_as("other/test.toml", flying_sheet, overrides));
  EXPECT_TRUE(holds(missing, "the run of " + path("other/../first.h5") +
                                 " reads \"shape.h5\", which is not there\n  expected " +
                                 path("shape.h5") + " or " + path("other/shape.h5") + ';'))
      << missing;
  // A file of other contents does not serve, wherever it is found.
  for (const std::string name : {"other/shape.h5", "shape.h5"}) {
    write_shape(name, 0.2);
    const std::string changed = refusal_of(parse_as("other/test.toml", flying_sheet, overrides));
    EXPECT_TRUE(holds(changed, "files have changed since")) << changed;
  }
}

// A run that began in the state of a first one has a checkpoint from which a third one begins.
TEST_F(Restart, StartsFromARunThatWasRestarted) {
  write_shape("shape.h5", 0.1);
  std::filesystem::create_directory(path("other"));
  run("first.h5", parse(sheet_of_file));
  run("second.h5", parse(sheet_of_file, from("first.h5", checkpoint_time("first.h5"))));
  const Overrides overrides =
      from("../second.h5", checkpoint_time("second.h5"), {"body.sheet.shape.path=../shape.h5"});
  const Simulation third = make_simulation(parse_as("other/test.toml", sheet_of_file, overrides));
  const TrajectoryReader second(path("second.h5"));
  const std::vector<Vec3> end = second.positions(0, second.frames() - 1);
  for (std::size_t i = 0; i < end.size(); ++i)
    EXPECT_LT((third.position("sheet")[i] - end[i]).norm(), 1e-6) << i;
  std::filesystem::remove(path("first.h5"));
  const std::string gone = refusal_of(parse_as("other/test.toml", sheet_of_file, overrides));
  EXPECT_TRUE(holds(gone, "reads \"first.h5\", which is not there")) << gone;
}

// Two runs whose files were exchanged start in each other's states.
TEST_F(Restart, RefusesRunsThatStartFromEachOther) {
  write_shape("shape.h5", 0.1);
  run("one.h5", parse(sheet_of_file));
  run("two.h5", parse(sheet_of_file, from("one.h5", checkpoint_time("one.h5"))));
  run("new.h5", parse(sheet_of_file, from("two.h5", checkpoint_time("two.h5"))));
  for (const std::string end : {".h5", ".checkpoint"})
    std::filesystem::rename(path("new" + end), path("one" + end));
  const std::string text = refusal(sheet_of_file, from("one.h5", checkpoint_time("one.h5")));
  EXPECT_TRUE(holds(text, "more than 32 runs start in the state of another")) << text;
}

// An unreadable trajectory has the place of its path, as a shape file has.
TEST_F(Restart, PlacesATrajectoryThatCannotBeRead) {
  const std::string text =
      std::string(flying_sheet) + "[restart]\ntime = 0.05\n  path = \"a.h5\"\n";
  write("test.toml", text);
  const std::string missing = refusal(text, {});
  EXPECT_TRUE(holds(missing, path("test.toml") + ":18:10: " + path("a.h5") + ": no such file"))
      << missing;
  write("a.h5", "no trajectory");
  const std::string damaged = refusal(text, {});
  EXPECT_TRUE(holds(damaged, path("test.toml") + ":18:10: " + path("a.h5"))) << damaged;
  const std::string other = refusal(text, {"restart.path=b.h5"});
  EXPECT_EQ(other.find("--set restart.path=\"b.h5\": " + path("b.h5") + ": no such file"), 0)
      << other;
}

}  // namespace
}  // namespace weft::sim::restart_test
