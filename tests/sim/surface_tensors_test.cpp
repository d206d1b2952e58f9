// Strain, tension, curvature and moment by particle, against closed forms.
#include "sim/channels/surface_tensors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/dense_algebra.h"
#include "tests/measured_fabrics.h"
#include "tests/sim/channel_run.h"

namespace weft::sim::surface_tensors_test {
namespace {

const std::string stretched_sheet = R"(
[time]
duration = 0.3
frames_per_second = 50
[world]
gravity = [0, 0, 0]
[output]
channels = ["membrane_strain", "membrane_stress", "bending_curvature", "bending_moment",
            "body_energy"]
[contact]
enabled = false
[material.cloth]
membrane_stiffness = 500
poisson_ratio = 0.25
bending_stiffness = 2e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.2, 0.9], resolution = [10, 13] }
)";

Eigen::Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

std::vector<Vec3> directions_of(const PrincipalValues& values) {
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < values.major.size(); ++i)
    result.emplace_back(values.direction[3 * i], values.direction[3 * i + 1],
                        values.direction[3 * i + 2]);
  return result;
}

// Returns the sine of the angle between two lines.
double angle_between(const Vec3& a, const Vec3& b) {
  return a.cross(b).norm() / (a.norm() * b.norm());
}

double largest_component(const Vec3& v) {
  int place = 0;
  v.cwiseAbs().maxCoeff(&place);
  return v[place];
}

// A uniform stretch by 1.1 along an axis at 30 degrees to the columns and by 0.95 across it, after
// any rotation: E = (s^2 - 1) / 2, tension s1 S1 / s2 with the St. Venant-Kirchhoff law S = E h /
// (1 - nu^2) (E1 + nu E2).
TEST(SurfaceTensors, UniformStretchIsExactInAnyDirectionAndRotation) {
  const ChannelRun run(stretched_sheet);
  SceneBody body = run.scene().bodies[0];
  const Vec3 axis(std::cos(0.5235), std::sin(0.5235), 0), across(-axis.y(), axis.x(), 0);
  const double strain1 = (1.1 * 1.1 - 1) / 2, strain2 = (0.95 * 0.95 - 1) / 2;
  const double plate = 500 / (1 - 0.25 * 0.25);
  const double tension1 = plate * (strain1 + 0.25 * strain2) * 1.1 / 0.95;
  const double tension2 = plate * (strain2 + 0.25 * strain1) * 0.95 / 1.1;
  std::mt19937 random(5);
  const std::vector<Vec3> flat = body.rest;
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Matrix3d at_rest = random_rotation(random), now = random_rotation(random);
    std::vector<Vec3> position;
    for (std::size_t i = 0; i < flat.size(); ++i) {
      body.rest[i] = at_rest * flat[i] + Vec3(1, 2, 3);
      position.push_back(now *
                         (1.1 * axis.dot(flat[i]) * axis + 0.95 * across.dot(flat[i]) * across));
    }
    SurfaceTensors tensors(body, true, 1);
    tensors.place(position, std::vector<Vec3>(flat.size(), Vec3::Zero()), {});
    PrincipalValues strain, stress, curvature;
    tensors.find_strain(strain);
    tensors.find_stress(stress);
    tensors.find_curvature(curvature);
    for (std::size_t i = 0; i < flat.size(); ++i) {
      EXPECT_NEAR(strain.major[i], strain1, 1e-12);
      EXPECT_NEAR(strain.minor[i], strain2, 1e-12);
      EXPECT_NEAR(stress.major[i], tension1, 1e-9);
      EXPECT_NEAR(stress.minor[i], tension2, 1e-9);
      EXPECT_NEAR(curvature.major[i], 0, 1e-9);
      EXPECT_NEAR(curvature.minor[i], 0, 1e-9);
      for (const PrincipalValues* values : {&strain, &stress}) {
        const Vec3 direction = directions_of(*values)[i];
        EXPECT_NEAR(direction.norm(), 1, 1e-12);
        EXPECT_LT(angle_between(direction, now * axis), 1e-10);
        EXPECT_GT(largest_component(direction), 0);
      }
    }
  }
}

// A sheet that slides and turns as a rigid body while it stretches along x at a rate: damping adds
// beta times the rate of Green strain to the strain that makes the tension.
TEST(SurfaceTensors, DampingAddsToTheTension) {
  const ChannelRun run(stretched_sheet, {"material.cloth.stiffness_damping=0.02"});
  const SceneBody& body = run.scene().bodies[0];
  const Vec3 spin(0.3, -1, 2);
  std::vector<Vec3> velocity;
  for (const Vec3& x : body.rest) velocity.push_back(Vec3(0.5 * x.x(), 0, 0) + spin.cross(x));
  SurfaceTensors tensors(body, false, 1);
  tensors.place(body.rest, velocity, {0.02, 0});
  PrincipalValues stress;
  tensors.find_stress(stress);
  const double plate = 500 / (1 - 0.25 * 0.25), strain = 0.02 * 0.5;
  for (std::size_t i = 0; i < body.rest.size(); ++i) {
    EXPECT_NEAR(stress.major[i], plate * strain, 1e-9);
    EXPECT_NEAR(stress.minor[i], 0.25 * plate * strain, 1e-9);
  }
}

// A sheet that is stretched at an angle to a column and then folded there by a right angle keeps
// its strain: at the crease, the triangles of both sides are turned into one plane.
TEST(SurfaceTensors, FoldedSheetKeepsItsStrain) {
  const ChannelRun run(stretched_sheet);
  const SceneBody& body = run.scene().bodies[0];
  Eigen::Matrix2d stretch;
  stretch << 1.1, 0.05, 0.05, 0.95;
  const Eigen::Matrix2d green = 0.5 * (stretch * stretch - Eigen::Matrix2d::Identity());
  const Eigen::Vector2d principal = eigenvalues(green);
  const Eigen::Vector2d crease = stretch.col(1).normalized();
  std::vector<Vec3> position;
  for (const Vec3& x : body.rest) {
    const Eigen::Vector2d flat = stretch * x.head<2>();
    const double along = crease.dot(flat), beside = crease.y() * flat.x() - crease.x() * flat.y();
    position.emplace_back(along, std::min(beside, 0.0), std::max(beside, 0.0));
  }
  SurfaceTensors tensors(body, false, 1);
  tensors.place(position, std::vector<Vec3>(position.size(), Vec3::Zero()), {});
  PrincipalValues strain;
  tensors.find_strain(strain);
  for (std::size_t i = 0; i < position.size(); ++i) {
    EXPECT_NEAR(strain.major[i], principal[1], 1e-12);
    EXPECT_NEAR(strain.minor[i], principal[0], 1e-12);
  }
}

// A flat sheet whose curvature along x grows by 3 /m every second: damping makes the moment D beta
// times that rate, and no curvature.
TEST(SurfaceTensors, BendingDampingAddsToTheMoment) {
  const ChannelRun run(stretched_sheet, {"material.cloth.bending_damping=0.1"});
  const SceneBody& body = run.scene().bodies[0];
  std::vector<Vec3> velocity;
  for (const Vec3& x : body.rest) velocity.emplace_back(0, 0, 0.5 * 3 * x.x() * x.x());
  SurfaceTensors tensors(body, true, 1);
  tensors.place(body.rest, velocity, {0, 0.1});
  PrincipalValues curvature, moment;
  tensors.find_curvature(curvature);
  tensors.find_moment(moment);
  for (int row = 2; row < 8; ++row) {
    for (int col = 2; col < 11; ++col) {
      EXPECT_NEAR(curvature.major[13 * row + col], 0, 1e-12);
      EXPECT_NEAR(moment.major[13 * row + col], 2e-3 * 0.1 * 3, 1e-10);
      EXPECT_NEAR(moment.minor[13 * row + col], 0.25 * 2e-3 * 0.1 * 3, 1e-10);
    }
  }
}

// Measured cloth stretched in one direction at 45 degrees to its warp, width held: the tension
// along the pull is the published one.
TEST(SurfaceTensors, MeasuredClothHasThePublishedTension) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    const ChannelRun run(stretched_sheet,
                         {"material.cloth={ preset = \"" + fabric.name + "\" }",
                          "body.sheet.warp_angle_deg=-45", "body.sheet.stretch=[1.06, 1, 1]"});
    const double strain = (1.06 * 1.06 - 1) / 2;
    const auto s = published_tension(fabric, strain / 2, strain / 2, strain / 2);
    const double along = 1.06 * (s[0] / 2 + s[1] / 2 + s[2]);  // force per length of the cut
    const std::vector<double> major = run.field("sheet", "membrane_stress_major");
    const std::vector<double> minor = run.field("sheet", "membrane_stress_minor");
    const std::vector<Vec3> direction = run.vectors("sheet", "membrane_stress_direction");
    for (std::size_t i = 0; i < major.size(); ++i) {
      const double c = direction[i].x() * direction[i].x();
      EXPECT_NEAR(major[i] * c + minor[i] * (1 - c), along, 1e-4 * along) << fabric.name;
    }
  }
}

// Cloth whose bending depends on direction and curvature, rolled along its warp, bias and weft.
TEST(SurfaceTensors, WovenClothHasTheMomentOfItsDirection) {
  const MeasuredFabric fabric = measured_fabrics()[6];
  for (int direction = 0; direction < 3; ++direction) {
    const ChannelRun run(stretched_sheet,
                         {"material.cloth={ preset = \"" + fabric.name + "\" }",
                          "body.sheet.shape.resolution=[19, 49]",
                          "body.sheet.warp_angle_deg=" + std::to_string(-45 * direction),
                          "body.sheet.start={ bend_radius = 0.2 }"});
    const double stiffness =  // at 5 1/m, between 0 and 10
        0.5 * (fabric.bending[direction][0] + fabric.bending[direction][1]);
    const std::vector<double> major = run.field("sheet", "bending_moment_major");
    const std::vector<double> minor = run.field("sheet", "bending_moment_minor");
    const std::vector<Vec3> axis = run.vectors("sheet", "bending_moment_direction");
    for (int row = 2; row < 17; ++row) {
      for (int col = 2; col < 47; ++col) {
        const int i = 49 * row + col;
        const double across = axis[i].y() * axis[i].y();
        EXPECT_NEAR(major[i] * (1 - across) + minor[i] * across, stiffness * 5,
                    0.01 * stiffness * 5);
      }
    }
  }
}

// A sheet bent to a cylinder of radius R at an angle to its grid: curvature 1/R along it and none
// across, moments D/R and nu D/R. Triangles at the border have no moment across it; vertices
// around which there are no others but these are left out.
TEST(SurfaceTensors, SheetBentToACylinderHasItsCurvatureAndMoment) {
  const ChannelRun run(stretched_sheet, {"body.sheet.shape.resolution=[37, 49]"});
  const SceneBody& body = run.scene().bodies[0];
  std::mt19937 random(7);
  for (const double radius : {0.5, 2.0}) {
    for (const double degrees : {0.0, 20.0, 45.0, 70.0, 90.0, 135.0}) {
      for (const double side : {1.0, -1.0}) {
        const double angle = degrees * std::acos(-1.0) / 180;
        const Vec3 along(std::cos(angle), std::sin(angle), 0), across(-along.y(), along.x(), 0);
        const Eigen::Matrix3d now = random_rotation(random);
        std::vector<Vec3> position, tangent;
        for (const Vec3& x : body.rest) {
          const double turn = along.dot(x) / radius;
          position.push_back(now * (radius * std::sin(turn) * along + across.dot(x) * across +
                                    side * radius * (1 - std::cos(turn)) * Vec3::UnitZ()));
          tangent.push_back(now * (std::cos(turn) * along + side * std::sin(turn) * Vec3::UnitZ()));
        }
        SurfaceTensors tensors(body, true, 1);
        tensors.place(position, std::vector<Vec3>(position.size(), Vec3::Zero()), {});
        PrincipalValues curvature, moment;
        tensors.find_curvature(curvature);
        tensors.find_moment(moment);
        for (int r = 2; r < 35; ++r) {
          for (int c = 2; c < 47; ++c) {
            const int i = 49 * r + c;
            const auto& values = side > 0 ? curvature.major : curvature.minor;
            const auto& others = side > 0 ? curvature.minor : curvature.major;
            ASSERT_NEAR(values[i], side / radius, 0.01 / radius) << degrees;
            ASSERT_NEAR(others[i], 0, 0.01 / radius) << degrees;
            const auto& moments = side > 0 ? moment.major : moment.minor;
            const auto& other_moments = side > 0 ? moment.minor : moment.major;
            ASSERT_NEAR(moments[i], side * 2e-3 / radius, 0.01 * 2e-3 / radius);
            ASSERT_NEAR(other_moments[i], side * 0.25 * 2e-3 / radius, 0.01 * 2e-3 / radius);
            const Vec3 major = directions_of(curvature)[i];
            ASSERT_LT(angle_between(major, side > 0 ? tangent[i] : Vec3(now * across)), 0.01);
          }
        }
      }
    }
  }
}

// Half a tube has no change of curvature at rest. Its normals point outwards, so unrolling it makes
// it hollower on their side by 1/R.
TEST(SurfaceTensors, CurvatureIsTheChangeSinceRest) {
  const ChannelRun run(stretched_sheet,
                       {R"(body.sheet.shape={ type = "cylinder", radius = 0.2, length = 0.4, )"
                        R"(resolution = [17, 48], angle_deg = 180 })"});
  const SceneBody& body = run.scene().bodies[0];
  const std::vector<Vec3> still(body.rest.size(), Vec3::Zero());
  SurfaceTensors tensors(body, true, 1);
  PrincipalValues curvature;
  tensors.place(body.rest, still, {});
  tensors.find_curvature(curvature);
  for (const double value : curvature.major) EXPECT_NEAR(value, 0, 1e-12);
  std::vector<Vec3> position;
  for (const Vec3& x : body.rest)
    position.emplace_back(0.2 * std::acos(std::clamp(x.x() / 0.2, -1.0, 1.0)), 0.0, x.z());
  tensors.place(position, still, {});
  tensors.find_curvature(curvature);
  for (int row = 2; row < 15; ++row) {
    for (int col = 2; col < 46; ++col) {
      EXPECT_NEAR(curvature.major[row * 48 + col], 5, 0.05);
      EXPECT_NEAR(curvature.minor[row * 48 + col], 0, 0.05);
      EXPECT_LT(angle_between(directions_of(curvature)[row * 48 + col], Vec3::UnitX()), 0.01);
    }
  }
}

// The sum of the energies of bodies is that of the forces, for triangles, springs and bending, on
// open, closed and sewn images.
TEST(SurfaceTensors, EnergiesOfBodiesAddUpToThoseOfForces) {
  ChannelRun run(R"(
[time]
duration = 1
[output]
channels = ["body_energy"]
[contact]
enabled = false
[material.cloth]
bending_stiffness = 1e-3
[material.flat]
poisson_ratio = 0.1
[material.net]
membrane = "springs"
bend_stiffness = 10
[material.woven]
[material.woven.orthotropic_membrane]
warp_curve = { strains = [0, 0.02, 0.1], tensions = [0, 5, 90] }
weft_stiffness = 300
shear_modulus = 15
[material.woven.orthotropic_bending]
warp = [2e-3]
bias = [1e-3]
weft = [1e-3]
[material.denim]
preset = "11oz-black-denim"
[[body]]
name = "woven"
material = "woven"
warp_angle_deg = 20
stretch = [1.05, 1.02, 1]
position = [0, 0, 5]
shape = { type = "cylinder", radius = 0.2, length = 0.5, resolution = [5, 9] }
[[body]]
name = "denim"
material = "denim"
warp_angle_deg = 70
stretch = [1.05, 1.02, 1.1]
position = [0, 0, 7]
shape = { type = "sphere", radius = 0.3, resolution = [4] }
[[body]]
name = "sheet"
material = "cloth"
stretch = [1.1, 0.97, 1]
angular_velocity_deg = [10, 20, 30]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 6] }
[[body]]
name = "tube"
material = "cloth"
stretch = [1.2, 1, 1.1]
position = [0, 3, 1]
velocity = [1, 2, 3]
shape = { type = "cylinder", radius = 0.2, length = 0.5, resolution = [5, 9] }
[[body]]
name = "ball"
material = "flat"
stretch = [1.1, 1, 1]
position = [3, 0, 1]
shape = { type = "sphere", radius = 0.3, resolution = [4] }
[[body]]
name = "net"
material = "net"
stretch = [1.05, 1.02, 1]
position = [-3, 0, 1]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 6] }
)");
  const Energies all = run.simulation().energies();
  Vec3 sum = Vec3::Zero();
  for (const char* body : {"woven", "denim", "sheet", "tube", "ball", "net"}) {
    const std::string path = std::string("body_energy/") + body + "/";
    const Vec3 energies(run.record(path + "kinetic")[0], run.record(path + "gravitational")[0],
                        run.record(path + "elastic")[0]);
    EXPECT_GT(energies[2], 0) << body;
    sum += energies;
  }
  double elastic = 0;
  for (const auto& [name, energy] : all.elastic) elastic += energy;
  EXPECT_NEAR(sum[0], all.kinetic, 1e-12 * all.kinetic);
  EXPECT_NEAR(sum[1], all.gravitational, 1e-12 * std::abs(all.gravitational));
  EXPECT_NEAR(sum[2], elastic, 1e-12 * elastic);
  EXPECT_EQ(run.record("body_energy/ball/kinetic")[0], 0);
  EXPECT_NEAR(run.record("body_energy/tube/kinetic")[0],
              0.5 * 14 * 0.2 * 2 * std::acos(-1.0) * 0.2 * 0.5, 0.03);
}

// A spinning annulus that internal damping has brought to rest in its own frame. Plane stress of a
// rotating disc with a hole, Timoshenko and Goodier 1970, Theory of Elasticity, section 32, with
// the mass per area in place of density times thickness:
//   N_r = (3 + nu)/8 rho w^2 (b^2 + a^2 - a^2 b^2 / r^2 - r^2)
//   N_t = (3 + nu)/8 rho w^2 (b^2 + a^2 + a^2 b^2 / r^2 - (1 + 3 nu)/(3 + nu) r^2)
TEST(SurfaceTensors, SpinningAnnulusHasTheTensionOfTheory) {
  ChannelRun run(R"(
[time]
duration = 0.5
position_tolerance = 1e-8
[world]
gravity = [0, 0, 0]
[output]
channels = ["membrane_strain", "membrane_stress"]
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 1000
poisson_ratio = 0.3
stiffness_damping = 0.02
[[body]]
name = "disc"
angular_velocity_deg = [0, 0, 171.88733853924697]
shape = { type = "annulus", outer_radius = 1, inner_radius = 0.4, resolution = [25, 120] }
)");
  run.advance_to(0.5);
  const double spin = run.angular_momentum().z();
  const auto& rest = run.scene().bodies[0].rest;
  double inertia = 0;
  for (std::size_t i = 0; i < rest.size(); ++i)
    inertia += run.scene().mass[i] * run.position()[i].head<2>().squaredNorm();
  const double w = spin / inertia, a = 0.4, b = 1, nu = 0.3;
  EXPECT_NEAR(w, 3, 0.01);
  const std::vector<double> major = run.field("disc", "membrane_stress_major");
  const std::vector<double> minor = run.field("disc", "membrane_stress_minor");
  const std::vector<double> strain = run.field("disc", "membrane_strain_major");
  const std::vector<Vec3> direction = run.vectors("disc", "membrane_stress_direction");
  const double scale = (3 + nu) / 8 * 0.2 * w * w;
  for (std::size_t i = 3 * 120; i < rest.size() - 3 * 120; ++i) {
    const double r = rest[i].norm(), hole = a * a * b * b / (r * r);
    const double radial = scale * (b * b + a * a - hole - r * r);
    const double hoop = scale * (b * b + a * a + hole - (1 + 3 * nu) / (3 + nu) * r * r);
    ASSERT_NEAR(major[i], hoop, 0.01 * hoop) << r;
    ASSERT_NEAR(minor[i], radial, 0.01 * hoop) << r;
    ASSERT_NEAR(strain[i], (hoop - nu * radial) / 1000, 0.01 * hoop / 1000) << r;
    ASSERT_LT(angle_between(direction[i], Vec3::UnitZ().cross(run.position()[i])), 0.03) << r;
  }
}

// A long strip, stretched by 5 % between two pinned ends: in its middle there is tension along it
// alone. Then E2 = -nu E1, S1 = E h E1, and the pins carry s2 w times the Cauchy tension.
TEST(SurfaceTensors, StretchedStripCarriesWhatItsPinsDo) {
  ChannelRun run(R"(
[time]
duration = 1
frames_per_second = 1
method = "static"
position_tolerance = 1e-8
[world]
gravity = [0, 0, 0]
[output]
channels = ["membrane_strain", "membrane_stress", "reactions"]
[contact]
enabled = false
[material.cloth]
membrane_stiffness = 1000
poisson_ratio = 0.3
[[body]]
name = "strip"
rotation_deg = [20, 40, 60]
stretch = [1.05, 0.985, 1]
shape = { type = "rectangle", size = [2, 0.25], resolution = [9, 65] }
[[body.pin]]
edges = ["first_col"]
[[body.pin]]
edges = ["last_col"]
)",
                 {"time.duration=1"});
  run.advance_to(1);
  const std::vector<double> strain = run.field("strip", "membrane_strain_major");
  const std::vector<double> across = run.field("strip", "membrane_strain_minor");
  const std::vector<double> stress = run.field("strip", "membrane_stress_major");
  const std::vector<double> other = run.field("strip", "membrane_stress_minor");
  const Vec3 pull = run.vector("reactions/strip/pin_2/force");
  const Vec3 axis = run.position()[4 * 65 + 33] - run.position()[4 * 65 + 31];
  for (int r = 0; r < 9; ++r) {
    const int i = r * 65 + 32;
    EXPECT_NEAR(across[i], -0.3 * strain[i], 0.01 * strain[i]);
    const double along = std::sqrt(1 + 2 * strain[i]), side = std::sqrt(1 + 2 * across[i]);
    EXPECT_NEAR(stress[i], 1000 * strain[i] * along / side, 0.01 * stress[i]);
    EXPECT_NEAR(other[i], 0, 0.01 * stress[i]);
    EXPECT_NEAR(pull.norm(), stress[i] * side * 0.25, 0.01 * pull.norm());
    EXPECT_LT(angle_between(run.vectors("strip", "membrane_stress_direction")[i], axis), 1e-3);
  }
  EXPECT_GT(pull.dot(axis), 0);
  EXPECT_LT((pull + run.vector("reactions/strip/pin_1/force")).norm(), 1e-6 * pull.norm());
}

// A strip is pulled until most of the load is carried by its strain limit. Without lateral
// contraction every triangle has the tension of the load.
TEST(SurfaceTensors, StrainLimitCarriesItsPartOfTheTension) {
  ChannelRun run(R"(
[time]
duration = 1
frames_per_second = 1
method = "static"
position_tolerance = 1e-8
[world]
gravity = [0, 0, 0]
[output]
channels = ["membrane_stress"]
[contact]
enabled = false
[material.cloth]
membrane_stiffness = 100
poisson_ratio = 0
strain_limit = 0.1
[[body]]
name = "strip"
shape = { type = "rectangle", size = [1, 0.2], resolution = [3, 11] }
[[body.pin]]
edges = ["first_col"]
[[load]]
type = "line"
body = "strip"
edges = ["last_col"]
force = [20, 0, 0]
)",
                 {"time.duration=1"});
  run.advance_to(1);
  for (const double stress : run.field("strip", "membrane_stress_major"))
    EXPECT_NEAR(stress, 20, 0.02);
  for (const double stress : run.field("strip", "membrane_stress_minor"))
    EXPECT_NEAR(stress, 0, 0.02);
}

}  // namespace
}  // namespace weft::sim::surface_tensors_test
