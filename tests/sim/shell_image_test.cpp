// Numbers that speak of vertices are, for shells, those of points of the surface: of the image that
// a run records, and not of control points.
#include <gtest/gtest.h>

#include <string>

#include "sim/scene/shell_body.h"
#include "sim/scene/sliding_supports.h"
#include "sim/simulation/simulation.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::shell_image_test {
namespace {

const std::string shell = R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.shell]
model = "shell"
youngs_modulus = 1e9
poisson_ratio = 0.3
shell_thickness = 0.01
volume_density = 1000
[[body]]
name = "plate"
)";

// A plate is bent to a part of a cylinder without stretch. Chords of its image are shorter than
// before, or as long. Those of its control net are up to 5 % longer.
TEST(ShellImage, LargestStretchIsThatOfTheSurface) {
  const std::string text =
      shell +
      "start = { bend_radius = 0.1 }\n"
      "shape = { type = \"rectangle\", size = [0.5, 0.5], resolution = [11, 11] }\n";
  SimulatedCase plate(text);
  EXPECT_NEAR(plate.dynamics().largest_stretch(plate.positions_at(0)), 0, 1e-5);
  // A uniform stretch is that of the image, too.
  std::vector<Vec3> stretched(plate.scene().bodies[0].rest.begin(),
                              plate.scene().bodies[0].rest.end());
  for (Vec3& x : stretched) x.x() *= 1.01;
  EXPECT_NEAR(plate.dynamics().largest_stretch(stretched), 0.01, 1e-9);
}

// Returns the centre (m) about which the pin of a scene turns.
Vec3 centre_of_pin(const Scene& scene) {
  if (!scene.first_holds.empty()) return scene.first_holds.front().centre;
  if (scene.bodies[0].supports) return scene.bodies[0].supports->motions[0].pose(0).centre;
  return scene.prescribed.front().motion.pose(0).centre;
}

// The centre is that of the vertices of cloth, whichever rows of control points a clamp adds.
TEST(ShellImage, PinsTurnAboutTheMeanOfTheirPoints) {
  const std::string plate =
      "shape = { type = \"rectangle\", size = [0.5, 0.5], resolution = [7, 9] }\n";
  const std::string vault =
      "shape = { type = \"cylinder\", radius = 0.5, length = 1, angle_deg = 120, resolution = [7, "
      "9] }\n";
  for (const std::string& shape : {plate, vault}) {
    for (const std::string edge : {"first_row", "first_col"}) {
      for (const std::string more : {"", "clamp = true\n", "clamp = true\nrelease_time = 1\n",
                                     "release_time = 1\n", "axes = [\"x\", \"z\"]\n"}) {
        const std::string pinned = shape + "[[body.pin]]\nedges = [\"" + edge + "\"]\n" + more +
                                   "motion = { angular_velocity_deg = [0, 20, 0] }\n";
        const auto cloth = build_scene(
            parse_case("[contact]\nenabled = false\n[material.cloth]\nbending_stiffness = "
                       "1e-3\n[[body]]\nname = \"plate\"\n" +
                           pinned,
                       "test.toml"));
        const auto scene = build_scene(parse_case(shell + pinned, "test.toml"));
        EXPECT_LT((centre_of_pin(*scene) - centre_of_pin(*cloth)).norm(), 1e-12)
            << shape << edge << ' ' << more;
      }
    }
  }
}

// A load in the middle of a roof moves a control point by a third more than the surface.
TEST(ShellImage, PathsEndAtTheLargestDisplacementOfTheSurface) {
  Simulation roof(build_scene(parse_case(R"(
[time]
method = "static"
duration = 1
frames_per_second = 100
[static]
loading = "arc_length"
largest_displacement = 0.01
first_load_factor = 0.02
largest_step = 1e-4
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.shell]
model = "shell"
youngs_modulus = 3.1e9
poisson_ratio = 0.3
shell_thickness = 0.00635
volume_density = 1000
[[body]]
name = "roof"
shape = { type = "cylinder", radius = 2.54, length = 0.508, angle_deg = 11.459, resolution = [9, 9] }
[[body.pin]]
edges = ["first_col", "last_col"]
[[load]]
body = "roof"
type = "point"
rows = [4, 4]
cols = [4, 4]
force = [-1000, 0, 0]
)",
                                         "test.toml")));
  const auto middle = [&] {
    const std::vector<int> point{4 * 9 + 4};
    return mean_of_image_points(roof.scene().bodies[0], roof.position("roof"), point);
  };
  const Vec3 start = middle();
  while (!roof.has_ended() && roof.time() < 1) ASSERT_FALSE(roof.step());
  EXPECT_GE((middle() - start).norm(), 0.01);
  EXPECT_LT((middle() - start).norm(), 0.0105);
}

}  // namespace
}  // namespace weft::sim::shell_image_test
