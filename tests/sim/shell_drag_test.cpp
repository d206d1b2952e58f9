// Drag of shells, on their curved surfaces: against closed forms and differences.
#include <cmath>
#include <numbers>

#include "simulated_case.h"

namespace weft::sim::shell_drag_test {
namespace {

constexpr double air = 1.2, normal = 1.1, tangential = 0.06;  // density and coefficients

std::string in_wind(const std::string& wind, const std::string& shape, int degree) {
  return R"(
[world]
air_density = 1.2
gravity = [0, 0, 0]
wind = )" +
         wind +
         R"(
[contact]
enabled = false
[material.sail]
model = "shell"
youngs_modulus = 1e7
poisson_ratio = 0.3
shell_thickness = 1e-3
volume_density = 500
normal_drag = 1.1
tangential_drag = 0.06
spline_degree = )" +
         std::to_string(degree) + "\n[[body]]\nname = \"sail\"\nshape = { " + shape + " }\n";
}
const std::string plate = "type = \"rectangle\", size = [1.5, 0.8], resolution = [6, 7]";

Vec3 sum(const std::vector<Vec3>& forces) {
  Vec3 total = Vec3::Zero();
  for (const Vec3& each : forces) total += each;
  return total;
}

// The net forces on a body without gravity; a shell at rest has those of the air alone.
std::vector<Vec3> forces(SimulatedCase& sim, const std::vector<double>& y, double time = 0) {
  std::vector<Vec3> force(sim.scene().mass.size());
  EXPECT_FALSE(sim.dynamics().net_forces(time, y, force));
  return force;
}

class ShellDrag : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Degrees, ShellDrag, testing::Values(2, 3));

TEST_P(ShellDrag, OfAPlateIsThatOfItsArea) {
  SimulatedCase facing(in_wind("[0, 0, 4]", plate, GetParam()));
  const Vec3 across = sum(forces(facing, facing.dynamics().initial_state()));
  EXPECT_LT((across - Vec3(0, 0, 0.5 * air * normal * 1.2 * 16)).norm(), 1e-9);
  SimulatedCase edgewise(in_wind("[3, 4, 0]", plate, GetParam()));
  const Vec3 along = sum(forces(edgewise, edgewise.dynamics().initial_state()));
  EXPECT_LT((along - 0.5 * air * tangential * 1.2 * 5 * Vec3(3, 4, 0)).norm(), 1e-9);
}

// A quarter of a cylinder with the normals from x to y: with c for a coefficient and q = 1/2 rho
// w^2 R L, the wind along x presses by q c_n (pi / 4, 1 / 2) and rubs by q c_t (pi / 4, -1 / 2).
TEST_P(ShellDrag, OfACylinderIsThatOfItsCurvedSurface) {
  SimulatedCase sim(in_wind(
      "[5, 0, 0]",
      "type = \"cylinder\", radius = 0.6, length = 0.9, angle_deg = 90, resolution = [5, 12]",
      GetParam()));
  const Vec3 force = sum(forces(sim, sim.dynamics().initial_state()));
  const double q = 0.5 * air * 25 * 0.6 * 0.9, quarter = std::numbers::pi / 4;
  const Vec3 expected = q * (normal * Vec3(quarter, 0.5, 0) + tangential * Vec3(quarter, -0.5, 0));
  EXPECT_LT((force - expected).norm(), 2e-3 * expected.norm());
}

// D is exact along the relative wind, apart or joined to the stiffness.
TEST_P(ShellDrag, HasTheMatrixOfItsSlopeAlongTheWind) {
  SimulatedCase sim(in_wind("[1, 2, 3]", plate, GetParam()));
  Dynamics& dynamics = sim.dynamics();
  std::vector<double> y = dynamics.initial_state();
  auto* const x = reinterpret_cast<Vec3*>(y.data());
  const std::size_t count = y.size() / 6;
  for (std::size_t i = 0; i < count; ++i) x[i].z() += 0.1 * x[i].x() * x[i].y();
  constexpr double step = 1e-5;
  const std::vector<Vec3> wind(count, Vec3(1, 2, 3));
  const auto moved = [&](double factor) {
    std::vector<double> result = y;
    auto* const v = reinterpret_cast<Vec3*>(result.data()) + count;
    for (std::size_t i = 0; i < count; ++i) v[i] = factor * wind[i];
    return forces(sim, result);
  };
  const std::vector<Vec3> plus = moved(step), minus = moved(-step);
  dynamics.assemble(0, y);
  std::vector<Vec3> apart(count), stiffness(count), joined(count);
  dynamics.damping().multiply(wind, apart, 1);
  dynamics.stiffness().multiply(wind, stiffness, 1);
  constexpr double gamma = 0.02;
  dynamics.assemble_joined(0, y, Definiteness::exact, gamma, wind);
  const std::vector<Vec3> product(dynamics.damping_product().begin(),
                                  dynamics.damping_product().end());
  dynamics.stiffness().multiply(wind, joined, 1);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 slope = (minus[i] - plus[i]) / (2 * step);
    EXPECT_LT((apart[i] - slope).norm(), 1e-6 * (1 + slope.norm()));
    EXPECT_LT((product[i] - apart[i]).norm(), 1e-12);
    EXPECT_LT((joined[i] - stiffness[i] - apart[i] / gamma).norm(), 1e-8 * (1 + joined[i].norm()));
  }
}

TEST(ShellDragInTime, FollowsTheCurvesOfWindDensityAndCoefficient) {
  SimulatedCase sim(in_wind("{ times = [0, 2], values = [[0, 0, 0], [0, 0, 8]] }", plate, 3),
                    {"world.air_density={ times = [0, 2], values = [1, 3] }",
                     "material.sail.normal_drag={ times = [0, 2], values = [0, 2] }"});
  const Vec3 force = sum(forces(sim, sim.dynamics().initial_state(), 0.5));
  EXPECT_LT((force - Vec3(0, 0, 0.5 * 1.5 * 0.5 * 1.2 * 4)).norm(), 1e-9);
}

TEST(ShellDragInTime, LetsAPlateFallAtItsTerminalVelocity) {
  SimulatedCase sim(in_wind("[0, 0, 0]", plate, 3), {"world.gravity=[0,0,-9.81]"});
  const double terminal = std::sqrt(2 * 0.5 * 9.81 / (air * normal));
  const std::vector<double> y = sim.advance_to(2);
  const double speed = terminal * std::tanh(9.81 * 2 / terminal);
  for (const Vec3& v : StateView::of(y).velocity) EXPECT_NEAR(-v.z(), speed, 2e-3 * speed);
}

}  // namespace
}  // namespace weft::sim::shell_drag_test
