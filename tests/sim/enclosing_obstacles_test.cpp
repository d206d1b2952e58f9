// Spheres that start inside closed obstacles, compared with sums of solid angles.
#include "sim/particles/enclosing_obstacles.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "sim/case/case_reader.h"
#include "sim/view/scene_description.h"

namespace weft::sim::enclosing_obstacles_test {
namespace {

// A lattice of small balls around obstacles: a turned torus, a sphere, an open tube, a floor and a
// tube whose walls are parallel to the lattice.
const std::string scene_text = R"(
[time]
method = "impulses"
duration = 1
[[particles]]
name = "dust"
radius = 1e-6
positions = { type = "grid", count = [24, 24, 24], spacing = 0.043, centre = [0.0013, 0.0021, 0.0037] }
[[particles]]
name = "far"
radius = 0.01
positions = { type = "grid", count = [2, 2, 2], centre = [0, 0, 5] }
[[obstacle]]
name = "torus"
rotation_deg = [20, 35, 10]
shape = { type = "torus", major_radius = 0.3, minor_radius = 0.12, resolution = [40, 20] }
[[obstacle]]
name = "ball"
position = [0.3, 0.3, 0.3]
shape = { type = "sphere", radius = 0.17, resolution = [9] }
[[obstacle]]
name = "tube"
shape = { type = "cylinder", radius = 0.45, length = 0.9, resolution = [9, 40] }
[[obstacle]]
name = "floor"
position = [0, 0, 0.4]
shape = { type = "plane", size = [2, 2] }
)";

// Returns the sum of the solid angles of all triangles seen from a point, over 4 pi (A. van
// Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30, 1983).
double winding_number(const Scene& scene, const SceneBody& body, const Vec3& point) {
  double sum = 0;
  for (const auto& triangle : body.mesh.triangles) {
    std::array<Vec3, 3> r;
    for (int k = 0; k < 3; ++k)
      r[k] = scene.initial_position[body.first_particle + triangle[k]] - point;
    const double a = r[0].norm(), b = r[1].norm(), c = r[2].norm();
    sum += 2 * std::atan2(r[0].dot(r[1].cross(r[2])),
                          a * b * c + r[0].dot(r[1]) * c + r[1].dot(r[2]) * a + r[2].dot(r[0]) * b);
  }
  return sum / (4 * std::numbers::pi);
}

TEST(EnclosedSpheres, AreThoseWithAWindingNumber) {
  const auto scene = build_scene(parse_case(scene_text, "case.toml"));
  std::vector<EnclosedSpheres> expected;
  for (int o = scene->dynamic_bodies; o < static_cast<int>(scene->bodies.size()); ++o) {
    const SceneBody& obstacle = scene->bodies[o];
    if (obstacle.name != "torus" && obstacle.name != "ball") continue;
    int count = 0;
    for (int i = 0; i < scene->bodies[0].particle_count(); ++i)
      count += std::abs(winding_number(*scene, obstacle, scene->initial_position[i])) > 0.5 ? 1 : 0;
    EXPECT_GT(count, 200);
    expected.push_back({0, o, count});
  }
  const std::vector<EnclosedSpheres> found = enclosed_spheres(*scene);
  ASSERT_EQ(found.size(), expected.size()) << [&] {
    std::string names;
    for (const EnclosedSpheres& each : found)
      names += scene->bodies[each.obstacle].name + ' ' + std::to_string(each.count) + ' ';
    return names;
  }();
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].group, expected[i].group);
    EXPECT_EQ(found[i].obstacle, expected[i].obstacle);
    EXPECT_EQ(found[i].count, expected[i].count);
  }
}

TEST(EnclosedSpheres, AreNotedByCheck) {
  const auto scene = build_scene(parse_case(R"(
[[particles]]
name = "drops"
radius = 0.01
positions = { type = "grid", count = [3, 1, 1], spacing = 0.2, centre = [0.2, 0, 0] }
[[obstacle]]
name = "drum"
shape = { type = "sphere", radius = 0.3, resolution = [9] }
[time]
duration = 1
)",
                                            "case.toml"));
  const std::string text = describe_scene(*scene);
  EXPECT_NE(text.find("  2 of 3 particles of drops start inside drum, whose surface is "
                      "closed: they stay there\n"),
            std::string::npos)
      << text;
}

}  // namespace
}  // namespace weft::sim::enclosing_obstacles_test
