// Trajectories of shells: images of points on their surfaces, and what is made of them.
#include <cmath>

#include "sim/run/recorded_run.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/recorded_surface.h"
#include "sim/view/trajectory_info.h"
#include "simulated_case.h"
#include "tests/sim/trajectory_fixture.h"

namespace weft::sim::shell_trajectory_test {
namespace {

const std::string tube = R"(
[time]
duration = 0.02
frames_per_second = 100
[output]
precision = "float64"
velocity = true
[material.solid]
model = "shell"
youngs_modulus = 1e6
poisson_ratio = 0.3
shell_thickness = 0.01
volume_density = 1000
[[body]]
name = "tube"
angular_velocity_deg = [0, 0, 90]
shape = { type = "cylinder", radius = 2, length = 3, resolution = [7, 12] }
)";

class ShellTrajectory : public TrajectoryFolder {
 protected:
  std::string run(const Overrides& overrides = {}) {
    RunOptions options;
    options.trajectory = path("run.h5");
    options.force = true;
    const RunReport report = run_simulation(parse_case(tube, "test.toml", overrides), options);
    EXPECT_EQ(report.status, RunReport::Status::done) << report.reason;
    return options.trajectory;
  }
};

TEST_F(ShellTrajectory, HoldsPointsOfTheSurface) {
  for (const int degree : {2, 3}) {
    const TrajectoryReader reader(run({"material.solid.spline_degree=" + std::to_string(degree)}));
    EXPECT_EQ(reader.bodies()[0].spline_degree, degree);
    const std::vector<Vec3> image = reader.positions(0, 0), velocity = reader.velocities(0, 0);
    ASSERT_EQ(image.size(), 84U);
    for (std::size_t i = 0; i < image.size(); ++i) {
      EXPECT_NEAR(std::hypot(image[i].x(), image[i].y()), 2, 1e-12);
      const Vec3 expected = Vec3(0, 0, std::acos(-1.0) / 2).cross(image[i]);
      EXPECT_LT((velocity[i] - expected).norm(), 1e-6);  // recorded in single precision
    }
  }
}

TEST_F(ShellTrajectory, BecomesTheTrianglesOfContactAgain) {
  const std::string file = run();
  const TrajectoryReader reader(file);
  const RecordedSurface surface(reader.bodies()[0]);
  ASSERT_TRUE(surface.is_curved());
  const auto scene = build_scene(parse_case(tube, "test.toml"));
  const SceneBody& body = scene->bodies[0];
  const std::vector<Vec3> image = reader.positions(0, 0), points = surface.points(image);
  const std::vector<Vec3>& expected = body.surface_rest();
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT((points[i] - expected[i]).norm(), 1e-12);
  EXPECT_EQ(surface.mesh().triangles, body.surface_mesh().triangles);
  EXPECT_NEAR(body.thickness, 0.01 + 2 * surface.deviation(image), 1e-12);
  // Constants and linear functions of the parameter stay what they are.
  for (const double value : surface.values(std::vector<double>(84, 3.0)))
    EXPECT_NEAR(value, 3, 1e-12);
  const TrajectorySummary summary = summarise_trajectory(file);
  ASSERT_TRUE(summary.bodies[0].deviation);
  // The largest of all frames; the tube turns and hardly bends.
  EXPECT_GE(summary.bodies[0].deviation->largest, surface.deviation(image));
  EXPECT_LT(summary.bodies[0].deviation->largest, 1.002 * surface.deviation(image));
  EXPECT_NE(to_text(summary).find("covers that"), std::string::npos);
  EXPECT_NE(to_json(summary).find("surface_deviation_m"), std::string::npos);
  for (const FrameCrossings& frame : count_crossings(file)) EXPECT_EQ(frame.count, 0);
}

TEST_F(ShellTrajectory, OfAPartHoldsPointsOfItsImage) {
  std::string text = tube;
  text += "[[output.part]]\nbody = \"tube\"\nrows = [0, 2]\n";
  RunOptions options;
  options.trajectory = path("part.h5");
  run_simulation(parse_case(text, "test.toml"), options);
  const TrajectoryReader reader(path("part.h5"));
  EXPECT_FALSE(RecordedSurface(reader.bodies()[0]).is_curved());
  for (const Vec3& x : reader.positions(0, 0)) EXPECT_NEAR(std::hypot(x.x(), x.y()), 2, 1e-12);
  EXPECT_FALSE(summarise_trajectory(path("part.h5")).bodies[0].deviation);
}

TEST_F(ShellTrajectory, RefusesImagesThatAreTooSmallForTheirDegree) {
  for (const int degree : {1, 3, 4}) {
    TrajectoryBody body = make_body("shell", {{.rows = 3, .cols = 5}});
    body.spline_degree = degree;
    const std::string file = path("small" + std::to_string(degree) + ".h5");
    const auto values = scene_values({body}, 0);
    TrajectoryWriter writer(file, {body}, {}, {}, views(values));
    writer.commit();
    EXPECT_THROW(TrajectoryReader{file}, FileError) << degree;
  }
}

}  // namespace
}  // namespace weft::sim::shell_trajectory_test
