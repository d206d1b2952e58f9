// Shells that bend far more than at rest: bounds of the curved surface hold piece by piece, and no
// curved surface passes through another one, though only triangles repel each other.
#include <cmath>
#include <random>

#include "bsi/proximity.h"
#include "sim/case/case_error.h"
#include "sim/contact/contact.h"
#include "sim/run/initial_state.h"
#include "sim/scene/spline_sampling.h"
#include "tests/sim/bad_case.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::curved_contact_test {
namespace {

// A thin flat sheet, bent to a gutter of the radius 0.1 m, above a plate in the plane z = 0. The
// sheet has 6 elements of 67 mm around: its surface leaves the triangles between its samples by 1.4
// mm. It is turned so that its lowest line lies in the middle between two rows of samples.
std::string gutter(double height, const std::string& more = "") {
  return R"(
[time]
duration = 0.1
position_tolerance = 2e-6
[world]
gravity = [0, 0, 0]
[contact]
range = 5e-4
[material.film]
model = "shell"
youngs_modulus = 1e8
poisson_ratio = 0.3
shell_thickness = 1e-4
volume_density = 1000
stiffness_damping = 1e-4
[[obstacle]]
name = "plate"
thickness = 1e-4
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[[body]]
name = "gutter"
self_contact = false
velocity = [0, 0, -0.5]
start = { bend_radius = 0.1 }
rotation_deg = [0, 9.549, 0]
shape = { type = "rectangle", size = [0.4, 0.1], resolution = [4, 9] }
position = [0, 0, )" +
         std::to_string(height) + "]\n" + more;
}

// The lowest points (m) of the samples and of the surface itself.
struct Lowest {
  double sample = INFINITY, surface = INFINITY;
};
Lowest lowest_of(const SceneBody& shell, std::span<const Vec3> control) {
  Lowest lowest;
  const auto& [u, v] = shell.spline->patches()[0];
  for (int i = 0; i <= 40 * u.elements(); ++i) {
    for (int j = 0; j <= 8 * v.elements(); ++j) {
      const SplineSurface::Place place{0, i / 40.0, j / 8.0};
      const double z = shell.spline->at(shell.atlas, place).position(control).z();
      lowest.surface = std::min(lowest.surface, z);
      if (i % 20 == 0 && j % 4 == 0) lowest.sample = std::min(lowest.sample, z);
    }
  }
  return lowest;
}

// The distance (m) of a point from the surface itself, between points 1.7 mm apart.
double nearest_of(const SceneBody& shell, std::span<const Vec3> control, const Vec3& point) {
  double nearest = INFINITY;
  const auto& [u, v] = shell.spline->patches()[0];
  for (int i = 0; i <= 40 * u.elements(); ++i) {
    for (int j = 0; j <= 40 * v.elements(); ++j) {
      const SplineSurface::Place place{0, i / 40.0, j / 40.0};
      const Vec3 at = shell.spline->at(shell.atlas, place).position(control);
      nearest = std::min(nearest, (at - point).norm());
    }
  }
  return nearest;
}

// The height (m) of the gutter's lowest sample above the plate for the height 0 of its body.
Lowest lowest_at_zero() {
  const auto scene = build_scene(parse_case(gutter(0), "test.toml"));
  return lowest_of(scene->bodies[0],
                   std::span(scene->initial_position).first(scene->dynamic_particles));
}

// The distance of a point from a triangle, m.
double distance(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::sqrt(bsi::closest_vertex_triangle(point, a, b, c).squared_distance);
}

}  // namespace

// Each piece of a strongly bent surface is within the bounds of the samples around it.
TEST(CurvedContact, BoundsHoldAroundEachSample) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> entry(-1, 1);
  for (const int degree : {2, 3}) {
    for (const bool wraps : {false, true}) {
      const bsi::Atlas atlas({{.rows = 6, .cols = 9, .wrap_u = wraps}});
      const SplineSurface surface(atlas, degree);
      const SplineSampling sampling(atlas, surface);
      std::vector<Vec3> control(atlas.particle_count()), samples;
      // A spiral that bends more and more, with some noise.
      for (int i = 0; i < 54; ++i) {
        const double angle = 0.1 * std::pow(i % 9, 2);
        control[i] = Vec3(std::cos(angle), 0.5 * (i / 9), std::sin(angle)) +
                     0.05 * Vec3(entry(random), entry(random), entry(random));
      }
      sampling.map.points_of(control, sampling.atlas.particle_count(), samples);
      std::vector<double> bounds(samples.size(), 0.0);
      raise_to_deviations(atlas, surface, sampling.atlas, control, bounds);
      EXPECT_EQ(std::ranges::max(bounds), deviation_from_samples(atlas, surface, control));
      EXPECT_LT(std::ranges::min(bounds), 0.7 * std::ranges::max(bounds));
      const bsi::Mesh mesh = bsi::build_mesh(sampling.atlas);
      const auto& [u, v] = surface.patches()[0];
      const int cols = sampling.atlas.patches()[0].cols;
      for (int row = 0; row < 2 * v.elements(); ++row) {
        for (int col = 0; col < 2 * u.elements(); ++col) {
          const int quad = row * (wraps ? cols : cols - 1) + col;
          double bound = 0, farthest = 0;
          for (const int t : {2 * quad, 2 * quad + 1}) {
            for (const int corner : mesh.triangles[t]) bound = std::max(bound, bounds[corner]);
          }
          for (int i = 0; i < 25; ++i) {
            const SplineSurface::Place place{0, (col + i % 5 / 4.0) / 2, (row + i / 5 / 4.0) / 2};
            const Vec3 x = surface.at(atlas, place).position(control);
            double nearest = INFINITY;
            for (const int t : {2 * quad, 2 * quad + 1}) {
              const auto& [a, b, c] = mesh.triangles[t];
              nearest = std::min(nearest, distance(x, samples[a], samples[b], samples[c]));
            }
            farthest = std::max(farthest, nearest);
          }
          EXPECT_LE(farthest, bound) << row << ' ' << col;
        }
      }
    }
  }
}

// Two shells and a plate in random places and strongly bent: where the check of a path passes, the
// surfaces sampled finely keep apart at its ends and in between.
TEST(CurvedContact, PathsThatPassKeepTheCurvedSurfaceApart) {
  const Lowest zero = lowest_at_zero();
  const auto scene = build_scene(parse_case(gutter(0.01 - zero.sample), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> entry(-1, 1);
  int passed = 0, refused = 0, crossed = 0;
  for (int trial = 0; trial < 60; ++trial) {
    // Moves the sheet down to a height at which the samples keep their distance, and shakes it.
    std::vector<Vec3> start = scene->initial_position;
    const double drop = 0.0085 + 0.001 * entry(random);
    for (int i = 0; i < scene->dynamic_particles; ++i)
      start[i] += Vec3(0, 0, -drop) + 2e-4 * Vec3(entry(random), entry(random), entry(random));
    std::vector<Vec3> end = start;
    const double way = 5e-4 * entry(random);
    for (int i = 0; i < scene->dynamic_particles; ++i) end[i].z() += way;
    const auto fault = contact.check_path(start, end);
    double lowest = INFINITY;
    for (const auto* x : {&start, &end})
      lowest = std::min(
          lowest,
          lowest_of(scene->bodies[0], std::span(*x).first(scene->dynamic_particles)).surface);
    crossed += lowest <= 0 ? 1 : 0;
    if (!fault) {
      ++passed;
      EXPECT_GT(lowest, 0) << trial;
    } else {
      ++refused;
      EXPECT_EQ(fault->kind, ContactFault::Kind::curved) << fault->describe(*scene);
    }
  }
  // Triangles alone would let all of them pass.
  EXPECT_GT(passed, 5);
  EXPECT_GT(crossed, 5);
  EXPECT_LT(refused - crossed, 30);
}

// A surface that is bent no more than its thickness covers needs no more room than before.
TEST(CurvedContact, ThicknessCoversSlightBends) {
  const std::string thick = "thickness = 6e-3\n";
  const auto scene = build_scene(parse_case(gutter(0, thick), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  std::vector<Vec3> position = scene->initial_position;
  const double up = 1e-6 + 0.5 * (6e-3 + 1e-4) - lowest_at_zero().sample;
  for (int i = 0; i < scene->dynamic_particles; ++i) position[i].z() += up;
  const auto fault = contact.check_path(position, position);
  EXPECT_FALSE(fault) << fault->describe(*scene);
}

// A start whose triangles keep their distance, though the surface itself passes through the plate.
TEST(CurvedContact, AStartThroughThePlateIsRefused) {
  const Lowest zero = lowest_at_zero();
  ASSERT_LT(zero.surface, zero.sample - 1e-3);
  const auto scene = build_scene(parse_case(gutter(4e-4 - zero.sample), "test.toml"));
  try {
    check_initial_state(*scene);
    FAIL() << "accepted";
  } catch (const CaseError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("the curved surfaces at body \"gutter\", row "), std::string::npos) << text;
    EXPECT_NE(text.find("may pass through each other"), std::string::npos) << text;
    EXPECT_NE(text.find("expected bodies farther apart"), std::string::npos) << text;
  }
  check_initial_state(*build_scene(parse_case(gutter(3e-3 - zero.sample), "test.toml")));
}

// The gutter falls on the plate. Its triangles would come to rest 0.1 to 0.6 mm above the plate,
// with the surface between them below it.
TEST(CurvedContact, ARunEndsBeforeCurvedSurfacesMeet) {
  const double height = 3e-3 - lowest_at_zero().sample;
  for (const Overrides& overrides :
       std::vector<Overrides>{{}, {"time.method=\"euler\"", "time.step=1e-3"}}) {
    Simulation simulation = simulation_of(gutter(height), overrides);
    std::optional<Failure> failure;
    while (simulation.time() < 0.1 && !failure) {
      failure = simulation.step();
      EXPECT_GT(lowest_of(simulation.scene().bodies[0], simulation.position("gutter")).surface, 0)
          << simulation.time();
    }
    ASSERT_TRUE(failure);
    // cvode ends at its shortest step, euler after a number of cuts.
    EXPECT_TRUE(failure->kind == Failure::Kind::surfaces ||
                failure->kind == Failure::Kind::too_many_cuts)
        << failure->text;
    EXPECT_NE(failure->text.find("the curved surfaces at body \"gutter\""), std::string::npos)
        << failure->text;
    EXPECT_NE(failure->text.find("a finer image, or a larger thickness"), std::string::npos)
        << failure->text;
    EXPECT_GT(simulation.time(), 1e-3);
    EXPECT_LT(simulation.time(), 0.02);
  }
}

// A sphere below the lowest line of the gutter, between two rows of samples.
std::string above_a_sphere(double distance) {
  return gutter(0.5,
                "[[particles]]\nname = \"ball\"\nradius = 5e-3\ndensity = 2e4\nspin = false\n"
                "positions = { type = \"grid\", count = [1, 1, 1], centre = [0.0166, 0, " +
                    std::to_string(0.5 - distance) + "] }\n");
}

TEST(CurvedContact, ASphereIsKeptFromTheCurvedSurface) {
  try {
    check_initial_state(*build_scene(parse_case(above_a_sphere(0.0055), "test.toml")));
    FAIL() << "accepted";
  } catch (const CaseError& error) {
    EXPECT_NE(std::string(error.what()).find("the curved surfaces at "), std::string::npos)
        << error.what();
  }
  Simulation simulation = simulation_of(above_a_sphere(0.009));
  check_initial_state(simulation.scene());
  std::optional<Failure> failure;
  while (simulation.time() < 0.03 && !failure) {
    failure = simulation.step();
    const Vec3 ball = simulation.position("ball")[0];
    EXPECT_GT(nearest_of(simulation.scene().bodies[0], simulation.position("gutter"), ball), 5e-3)
        << simulation.time();
  }
  ASSERT_TRUE(failure);
  EXPECT_NE(failure->text.find("the curved surfaces at "), std::string::npos) << failure->text;
}

// The advice of the message helps.
TEST(CurvedContact, AFinerImageOrALargerThicknessGoesOn) {
  const double height = 3e-3 - lowest_at_zero().sample;
  for (const Overrides& overrides :
       std::vector<Overrides>{{"body.gutter.shape.resolution=[4, 25]"},
                              {"body.gutter.thickness=6e-3",
                               "body.gutter.position.2=" + std::to_string(height + 3e-3)}}) {
    Simulation simulation = simulation_of(gutter(height), overrides);
    bool touched = false;
    while (simulation.time() < 0.012) {
      const auto failure = simulation.step();
      ASSERT_FALSE(failure) << failure->text;
      touched |= simulation.contact_pairs() > 0;
      EXPECT_GT(lowest_of(simulation.scene().bodies[0], simulation.position("gutter")).surface, 0);
    }
    EXPECT_TRUE(touched);
  }
}

}  // namespace weft::sim::curved_contact_test
