// Trajectories of particles: what the file holds, and what reads it.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <cstring>

#include "sim/case/case_reader.h"
#include "sim/run/recorded_run.h"
#include "sim/scene/scene.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/scene_description.h"
#include "sim/view/trajectory_info.h"
#include "tests/sim/same_datasets.h"
#include "tests/temporary_folder.h"

namespace weft::sim::particles_trajectory_test {
namespace {

// Two groups that fly, one of them onto a floor.
const std::string flight = R"case(
[time]
method = "impulses"
duration = 0.2
frames_per_second = 20
[output]
velocity = true
precision = "float64"
[outputs]
height = "last(position('few', 0, 2).z)"
[[particles]]
name = "few"
radius = 0.02
velocity = [1, 0, 2]
positions = { type = "grid", count = [3, 1, 1], centre = [0, 0, 1] }
[[particles]]
name = "many"
radius = 0.01
positions = { type = "random", number = 20, region_min = [0, 0, 0.05], region_max = [1, 1, 0.2] }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [9, 9] }
)case";

class ParticlesTrajectory : public testing::Test {
 protected:
  std::string run(const std::string& text) const {
    RunOptions options;
    options.trajectory = folder_.path("run.h5");
    options.force = true;
    const RunReport report = run_simulation(parse_case(text, "test.toml"), options);
    EXPECT_EQ(report.status, RunReport::Status::done) << report.reason;
    return options.trajectory;
  }
  std::string path(const std::string& name) const { return folder_.path(name); }

 private:
  TemporaryFolder folder_;
};

std::vector<double> numbers_of(const RawDataset& dataset) {
  std::vector<double> numbers(dataset.bytes.size() / sizeof(double));
  std::memcpy(numbers.data(), dataset.bytes.data(), dataset.bytes.size());
  return numbers;
}

TEST_F(ParticlesTrajectory, HasAGroupPerName) {
  const std::string file_path = run(flight);
  const hid_t file = H5Fopen(file_path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const RawDataset few = read_raw(file, "/particles/few/position");
  EXPECT_EQ(few.shape, (std::vector<hsize_t>{5, 3, 3}));
  EXPECT_EQ(read_raw(file, "/particles/many/position").shape, (std::vector<hsize_t>{5, 20, 3}));
  EXPECT_EQ(read_raw(file, "/particles/few/velocity").shape, (std::vector<hsize_t>{5, 3, 3}));
  EXPECT_EQ(numbers_of(read_raw(file, "/particles/few/radius")), std::vector<double>(3, 0.02));
  EXPECT_FALSE(dataset_paths(file).contains("body/few/position"));
  EXPECT_TRUE(dataset_paths(file).contains("body/floor/position"));
  // Ballistic flight: x = x0 + v t + g t^2 / 2 in every frame.
  const std::vector<double> numbers = numbers_of(few);
  for (int frame = 0; frame < 5; ++frame) {
    const double t = 0.05 * frame;
    for (int i = 0; i < 3; ++i) {
      const double* x = &numbers[9 * frame + 3 * i];
      EXPECT_NEAR(x[0], (i - 1) * 0.044 + t, 1e-12);
      EXPECT_NEAR(x[2], 1 + 2 * t - 9.81 / 2 * t * t, 2e-5);  // linear between two steps
    }
  }
  H5Fclose(file);
}

TEST_F(ParticlesTrajectory, IsReadBack) {
  const TrajectoryReader reader(run(flight));
  ASSERT_EQ(reader.bodies().size(), 3U);
  EXPECT_EQ(reader.bodies()[0].name, "floor");
  const TrajectoryBody& many = reader.bodies()[2];
  EXPECT_EQ(many.name, "many");
  EXPECT_EQ(many.radii, std::vector<double>(20, 0.01));
  EXPECT_EQ(many.atlas.quad_count(), 0);
  EXPECT_EQ(reader.positions(2, 4).size(), 20U);
  EXPECT_EQ(reader.velocities(2, 4).size(), 20U);
  for (const Vec3& x : reader.positions(2, 0)) {
    EXPECT_GE(x.z(), 0.05);
    EXPECT_LE(x.z(), 0.2);
  }
}

TEST_F(ParticlesTrajectory, IsSummarised) {
  const std::string text = to_text(summarise_trajectory(run(flight)));
  EXPECT_NE(text.find("particles many: 20 of radius 0.01 m"), std::string::npos) << text;
  EXPECT_NE(text.find("particles few: 3 of radius 0.02 m"), std::string::npos) << text;
}

TEST_F(ParticlesTrajectory, GivesOutputs) {
  RunOptions options;
  options.trajectory = path("outputs.h5");
  const RunReport report = run_simulation(parse_case(flight, "test.toml"), options);
  ASSERT_EQ(report.outputs.size(), 1U);
  EXPECT_NEAR(report.outputs[0].second, 1 + 2 * 0.2 - 9.81 / 2 * 0.04, 2e-5);
}

TEST_F(ParticlesTrajectory, HasNoArea) {
  for (const std::string output : {"shadow('few').z", "area('few')"}) {
    std::string text = flight;
    const std::string table = "[outputs]\n";
    text.insert(text.find(table) + table.size(), "covered = \"last(" + output + ")\"\n");
    RunOptions options;
    options.trajectory = path("covered.h5");
    try {
      run_simulation(parse_case(text, "test.toml"), options);
      ADD_FAILURE() << output;
    } catch (const CaseError& error) {
      EXPECT_NE(
          std::string(error.what())
              .find("\"few\" are particles, which have no " + output.substr(0, output.find('('))),
          std::string::npos)
          << error.what();
    }
  }
}

TEST_F(ParticlesTrajectory, IsAShapeOfPlacesForAnotherCase) {
  // The dataset [n, 3] of a file gives the places of a case.
  const std::vector<double> places{0, 0, 1, 0.5, 0, 1, 0, 0.5, 2};
  const std::string file_path = path("places.h5");
  const hid_t file = H5Fcreate(file_path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const std::vector<hsize_t> shape{3, 3};
  const hid_t space = H5Screate_simple(2, shape.data(), nullptr);
  const hid_t dataset =
      H5Dcreate2(file, "places", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, places.data());
  H5Dclose(dataset);
  H5Sclose(space);
  H5Fclose(file);
  const std::string text =
      "[time]\nmethod = \"impulses\"\n[[particles]]\nname = \"balls\"\nradius = 0.1\n"
      "positions = { type = \"file\", path = \"places.h5\", dataset = \"places\" }\n";
  const auto scene = build_scene(parse_case(text, path("test.toml")));
  ASSERT_EQ(scene->initial_position.size(), 3U);
  EXPECT_EQ(scene->initial_position[2], Vec3(0, 0.5, 2));
  EXPECT_NEAR(scene->mass[0], 1000 * 4.0 / 3 * std::acos(-1.0) * 1e-3, 1e-12);
}

TEST_F(ParticlesTrajectory, IsDescribedByCheck) {
  const std::string text = describe_scene(*build_scene(parse_case(flight, "test.toml")));
  EXPECT_NE(text.find("particles few: 3 of radius 0.02 m and mass "), std::string::npos) << text;
  EXPECT_NE(text.find("contact   impulses of particles with each other and with 1 obstacle\n"
                      "  skipped range, stiffness, "),
            std::string::npos)
      << text;
}

TEST_F(ParticlesTrajectory, PairsAreDescribedByCheckForEveryMethod) {
  for (const char* method : {"impulses", "cvode"}) {
    const std::string text = describe_scene(*build_scene(parse_case(
        flight, "test.toml",
        {"time.method=\"" + std::string(method) + "\"", "particles.0.friction=0.25",
         "contact.pair=[{ between = [\"few\", \"floor\"], friction = 0.2, restitution = 0.9 }]"})));
    EXPECT_NE(text.find(", friction 0.25\n"), std::string::npos) << text;
    EXPECT_NE(text.find("  friction 0.2 of \"few\" and \"floor\", 1 pair of bodies\n"
                        "  restitution 0.9 of \"few\" and \"floor\", 1 pair of bodies\n"),
              std::string::npos)
        << text;
  }
}

// A ball on a sheet, with a channel that particles do not have.
const std::string ball_on_sheet = R"case(
[time]
duration = 0.1
frames_per_second = 20
[output]
channels = ["velocity", "contact_force", "friction_force", "membrane_strain", "body_energy", "reactions"]
[outputs]
height = "last(position('ball', 0, 0).z)"
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.4, 0.4], resolution = [7, 7] }
[[body.pin]]
corners = ["first_first", "last_last"]
[[particles]]
name = "ball"
radius = 0.03
friction = 0.3
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 0.04] }
)case";

TEST_F(ParticlesTrajectory, HasBodiesBesideParticles) {
  const std::string file_path = run(ball_on_sheet);
  const hid_t file = H5Fopen(file_path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  EXPECT_EQ(read_raw(file, "/particles/ball/position").shape, (std::vector<hsize_t>{3, 1, 3}));
  EXPECT_EQ(read_raw(file, "/particles/ball/velocity").shape, (std::vector<hsize_t>{3, 1, 3}));
  const std::set<std::string> paths = dataset_paths(file);
  EXPECT_TRUE(paths.contains("body/sheet/position"));
  EXPECT_TRUE(paths.contains("body/sheet/contact_force"));
  EXPECT_TRUE(paths.contains("body/sheet/friction_force"));
  EXPECT_FALSE(paths.contains("particles/ball/contact_force"));
  H5Fclose(file);
  const std::string text = to_text(summarise_trajectory(file_path));
  EXPECT_NE(text.find("particles ball: 1 of radius 0.03 m"), std::string::npos) << text;
  EXPECT_NE(text.find("sheet"), std::string::npos) << text;
  const TrajectoryReader reader(file_path);
  EXPECT_EQ(reader.positions(1, 2).size(), 1U);
}

// A ball slides and turns ever faster, by 5/2 friction g / radius, on a floor where it touches it
// at t = 0. Frames lie between steps.
TEST_F(ParticlesTrajectory, HasAngularVelocities) {
  const std::string file_path = run(R"case(
[time]
method = "impulses"
step = 3e-3
duration = 0.1
frames_per_second = 100
[output]
channels = ["angular_velocity"]
[[particles]]
name = "ball"
radius = 0.05
friction = 0.1
restitution = 0
velocity = [2, 0, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 0.051] }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [9, 9] }
)case");
  const hid_t file = H5Fopen(file_path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  EXPECT_EQ(read_raw(file, "/particles/ball/angular_velocity").shape,
            (std::vector<hsize_t>{11, 1, 3}));
  EXPECT_FALSE(dataset_paths(file).contains("body/floor/angular_velocity"));
  H5Fclose(file);
  const TrajectoryReader reader(file_path);
  const double acceleration = 2.5 * 0.1 * 9.81 / 0.05;
  const auto turning = [&](int frame) {
    return reader.field_values(1, "angular_velocity", frame)[1];
  };
  EXPECT_NEAR((turning(10) - turning(5)) / 0.05, acceleration, 0.01 * acceleration);
  EXPECT_NEAR((turning(6) - turning(5)) / 0.01, acceleration, 0.01 * acceleration);
}

}  // namespace
}  // namespace weft::sim::particles_trajectory_test
