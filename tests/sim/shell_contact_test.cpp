// Contact of shells: their curved surfaces, sampled far more finely than the triangles of contact,
// never cross; momentum stays; and how far a surface is from its triangles.
#include <cmath>
#include <random>

#include "bench/dropped_shells.h"
#include "sim/scene/spline_sampling.h"
#include "sim/simulation/simulation.h"
#include "simulated_case.h"

namespace weft::sim::shell_contact_test {
namespace {

std::string path_of(const std::string& name) {
  return WEFT_CASES_DIR "/benchmarks/" + name + ".toml";
}

std::vector<Vec3> all_positions(const Simulation& simulation) {
  std::vector<Vec3> position, velocity;
  simulation.dynamics().expand_all(simulation.time(), simulation.state(), position, velocity);
  return position;
}

const std::string plastic = R"(
[material.plastic]
model = "shell"
youngs_modulus = 1e8
poisson_ratio = 0.35
shell_thickness = 1e-3
volume_density = 1000
bending_damping = 1e-3
stiffness_damping = 1e-3
)";

// At the start and at ten later times.
TEST(ShellContact, SurfacesNeverCross) {
  for (const char* name : {"shell_on_sphere", "shell_on_cloth"}) {
    const bench::ShellDrop drop = bench::drop_shell(read_case(path_of(name)));
    EXPECT_EQ(drop.crossings, 0) << name;
    EXPECT_TRUE(drop.touched) << name;
  }
}

// A sheet that starts across the ball, and one above it.
TEST(ShellContact, CrossingsAreCounted) {
  const auto count = [](const std::string& height) {
    const auto scene = build_scene(
        read_case(path_of("shell_on_sphere"), {"body.sheet.position=[0,0," + height + "]"}));
    Statistics statistics;
    Dynamics dynamics(*scene, statistics);
    std::vector<Vec3> position, velocity;
    dynamics.expand_all(0, dynamics.initial_state(), position, velocity);
    return bench::surface_crossings(*scene, position);
  };
  EXPECT_GT(count("0.05"), 20);
  EXPECT_EQ(count("0.106"), 0);
}

// The momentum (kg m/s) and the angular momentum (kg m^2/s) of all dynamic bodies.
std::pair<Vec3, Vec3> momenta(const Simulation& simulation) {
  const StateView state = StateView::of(simulation.state());
  std::vector<Vec3> weighted(state.velocity.size());
  simulation.dynamics().mass().multiply(state.velocity, weighted, 1);
  std::pair<Vec3, Vec3> sums{Vec3::Zero(), Vec3::Zero()};
  for (std::size_t i = 0; i < weighted.size(); ++i) {
    sums.first += weighted[i];
    sums.second += state.position[i].cross(weighted[i]);
  }
  return sums;
}

// A shell meets another one and a cloth, all free, with friction.
TEST(ShellContact, KeepsMomentumAndAngularMomentum) {
  Simulation simulation(build_scene(parse_case(R"(
[time]
duration = 0.2
relative_tolerance = 1e-5
velocity_tolerance = 1e-4
[world]
gravity = [0, 0, 0]
[contact]
range = 3e-3
friction = 0.4
)" + plastic + R"(
[material.cotton]
density = 0.5
membrane_stiffness = 500
[[body]]
name = "upper"
material = "plastic"
velocity = [0.3, 0, -1]
angular_velocity_deg = [40, 0, 20]
position = [0.02, 0.01, 0.02]
shape = { type = "rectangle", size = [0.15, 0.1], resolution = [5, 7] }
[[body]]
name = "lower"
material = "plastic"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [6, 6] }
[[body]]
name = "cloth"
material = "cotton"
position = [-0.01, 0, -0.02]
velocity = [0, 0.2, 0.5]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [7, 7] }
)",
                                               "test.toml")));
  const auto [momentum, spin] = momenta(simulation);
  bool touched = false;
  double way = 0;
  for (int i = 0; i < 5; ++i) {
    const auto failure = simulation.advance(0.02);
    ASSERT_FALSE(failure) << failure->text;
    touched |= simulation.contact_pairs() > 0;
    const auto [now, turning] = momenta(simulation);
    EXPECT_LT((now - momentum).norm(), 1e-4 * momentum.norm());
    EXPECT_LT((turning - spin).norm(), 1e-3 * spin.norm());
    way = std::abs(simulation.velocity("upper")[0].z() + 1);
  }
  EXPECT_TRUE(touched);
  EXPECT_GT(way, 0.1);
  EXPECT_EQ(bench::surface_crossings(simulation.scene(), all_positions(simulation)), 0);
}

// Distance of a point from the triangles of a surface, m.
double distance_to(const Vec3& point, std::span<const Vec3> x,
                   const std::vector<std::array<int, 3>>& triangles) {
  double least = INFINITY;
  for (const auto& [a, b, c] : triangles)
    least = std::min(least, bsi::closest_vertex_triangle(point, x[a], x[b], x[c]).squared_distance);
  return std::sqrt(least);
}

// The bound holds for any control points, and it is no more than a few times too large for waves
// that the image resolves.
TEST(SplineSampling, BoundsTheDistanceOfTheSurfaceFromItsTriangles) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> entry(-1, 1);
  for (const int degree : {2, 3}) {
    for (const bool wraps : {false, true}) {
      for (const bool smooth : {false, true}) {
        const bsi::Atlas atlas({{.rows = 6, .cols = 9, .wrap_u = wraps}});
        const SplineSurface surface(atlas, degree);
        std::vector<Vec3> control(atlas.particle_count());
        for (int i = 0; i < 54; ++i) {
          const int row = i / 9, col = i % 9;
          const double angle = 2 * std::acos(-1.0) * col / 9;
          control[i] = wraps ? Vec3(std::cos(angle), std::sin(angle), 0.3 * row)
                             : Vec3(col, row, 0.2 * std::sin(0.7 * col));
          if (!smooth) control[i] += 0.3 * Vec3(entry(random), entry(random), entry(random));
        }
        // A surface through points has even parameters also at its ends.
        if (smooth) control = surface.interpolate(atlas, control);
        const SplineSampling sampling(atlas, surface);
        std::vector<Vec3> samples;
        sampling.map.points_of(control, sampling.atlas.particle_count(), samples);
        const auto triangles = bsi::build_mesh(sampling.atlas).triangles;
        double largest = 0;
        const auto& [u, v] = surface.patches()[0];
        for (double at_v = 0.07; at_v < v.elements(); at_v += 0.23) {
          for (double at_u = 0.11; at_u < u.elements(); at_u += 0.23) {
            const Vec3 x = surface.at(atlas, {0, at_u, at_v}).position(control);
            largest = std::max(largest, distance_to(x, samples, triangles));
          }
        }
        const double bound = deviation_from_samples(atlas, surface, control);
        EXPECT_LE(largest, bound);
        EXPECT_GT(largest, (smooth ? 0.2 : 0.02) * bound);
      }
    }
  }
}

// A shell that is bent at rest keeps its surface apart by its own thickness.
TEST(ShellContact, ThicknessCoversTheRestSurface) {
  const auto scene = build_scene(read_case(path_of("shell_on_cloth")));
  const SceneBody& tile = scene->bodies[0];
  const double bound = deviation_from_samples(tile.atlas, *tile.spline, tile.rest);
  EXPECT_NEAR(tile.thickness, 1e-3 + 2 * bound, 1e-12);
  // The sagitta of an arc of half an element.
  const double chord = 0.1 * 80 * std::acos(-1.0) / 180 / (2 * 6);
  EXPECT_NEAR(bound, chord * chord / (8 * 0.1), 0.1 * bound);
}

}  // namespace
}  // namespace weft::sim::shell_contact_test
