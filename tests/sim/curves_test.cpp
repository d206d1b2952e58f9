// Keys that vary in time: exact motions by every method, matrices, what is skipped, saved states.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ostream>

#include "sim/case/case_error.h"
#include "sim/forces/force.h"
#include "sim/run/make_simulation.h"
#include "sim/scene/scene_curves.h"
#include "sim/view/scene_description.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::curves_test {
namespace {

// A free sheet across the wind. All its vertices move alike, whatever drives them.
constexpr const char* free_sheet = R"(
[time]
duration = 1
frames_per_second = 50
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 10
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
)";

struct Method {
  const char* name;
  Overrides overrides;
  // How much finer steps or tolerances become from one run to the next, and by which factor the
  // error must shrink at least.
  std::vector<const char*> refinements;
  double shrinks;
};

std::ostream& operator<<(std::ostream& stream, const Method& method) {
  return stream << method.name;
}

// The error of a method of order p is proportional to h^p, or with control of a local error of
// order p + 1 to tolerance^(p / (p + 1)). Three quarters of these exponents are asked for.
std::vector<Method> all_methods() {
  const std::vector<const char*> steps{"time.step=8e-3", "time.step=2e-3"};
  const std::vector<const char*> tolerances{"time.position_tolerance=1e-6",
                                            "time.position_tolerance=1e-8"};
  return {{"cvode", method("cvode"), tolerances, 10},
          {"arkode", method("arkode"), tolerances, 10},
          {"euler", method("euler"), tolerances, 5.6},
          {"euler_step", method("euler"), steps, 2.8},
          {"implicit_midpoint", method("implicit_midpoint"), steps, 8},
          {"verlet_step", method("verlet"), steps, 8}};
}

class CurvesByMethod : public testing::TestWithParam<Method> {
 protected:
  // The errors of a height at 0.3 s, of the coarse run and of the fine one.
  std::vector<double> errors(const Overrides& more, double exact) {
    std::vector<double> errors;
    for (const char* refinement : GetParam().refinements) {
      Overrides overrides = GetParam().overrides;
      overrides.emplace_back(refinement);
      if (has_tolerances()) overrides.emplace_back("time.relative_tolerance=1e-9");
      overrides.insert(overrides.end(), more.begin(), more.end());
      SimulatedCase sim(free_sheet, overrides);
      const std::vector<Vec3> places = sim.positions_at(0.3);
      errors.push_back(std::abs(places[4].z() - exact));
      for (const Vec3& place : places) EXPECT_NEAR(place.z(), places[4].z(), 1e-6);
    }
    return errors;
  }
  bool has_tolerances() const {
    return std::string(GetParam().refinements[0]).find("tolerance") != std::string::npos;
  }
  // The tightest tolerance may leave an error of `tolerances` times its size.
  void expect_order(const Overrides& more, double exact, double tolerances = 2) {
    const std::vector<double> of = errors(more, exact);
    EXPECT_LT(of[0], 0.1 * std::abs(exact));
    const double least = has_tolerances() ? tolerances * 1e-8 : 1e-9;
    EXPECT_LT(of[1], std::max(of[0] / GetParam().shrinks, least)) << of[0] << ' ' << of[1];
  }
};

INSTANTIATE_TEST_SUITE_P(All, CurvesByMethod, testing::ValuesIn(all_methods()),
                         [](const auto& one) { return std::string(one.param.name); });

// Gravity jumps at 0.1237 s, which is no multiple of any step.
TEST_P(CurvesByMethod, AFallUnderGravityThatJumpsIsExactToTheOrder) {
  constexpr double jump = 0.1237, end = 0.3, before = -4, after = 6;
  const double exact = 0.5 * before * jump * jump + before * jump * (end - jump) +
                       0.5 * after * (end - jump) * (end - jump);
  expect_order({"world.gravity={ times = [0, 0.1237], values = [[0, 0, -4], [0, 0, 6]], "
                "between = \"step\" }"},
               exact);
}

// Gravity rises in a straight line from 0 at 0.0537 s to a corner at 0.1237 s, and stays.
TEST_P(CurvesByMethod, AFallUnderGravityWithCornersIsExactToTheOrder) {
  constexpr double first = 0.0537, second = 0.1237, end = 0.3, g = 8;
  const double rise = second - first, rest = end - second;
  const double exact = g * rise * rise / 6 + 0.5 * g * rise * rest + 0.5 * g * rest * rest;
  expect_order({"world.gravity={ times = [0.0537, 0.1237], values = [[0, 0, 0], [0, 0, 8]] }"},
               exact);
}

// Wind across the sheet sets in at 0.1237 s. With c = rho C / (2 density) its speed w relative to
// the sheet follows w' = -c w^2, so w = w0 / (1 + c w0 t), and the sheet has gone
// w0 t - log(1 + c w0 t) / c.
TEST_P(CurvesByMethod, ASheetInAWindThatSetsInIsExactToTheOrder) {
  constexpr double jump = 0.1237, end = 0.3, wind = 5, c = 1.2 * 1.5 / (2 * 0.2), t = end - jump;
  const double exact = wind * t - std::log(1 + c * wind * t) / c;
  expect_order({"material.cloth.normal_drag=1.5",
                "world.wind={ times = [0, 0.1237], values = [[0, 0, 0], [0, 0, 5]], "
                "between = \"step\" }"},
               exact);
}

// In a gust across the sheet its speed v follows v' = c (u - v) |u - v|; the classic Runge-Kutta
// method with many steps finds it. Steps that the gust limits make loose tolerances exact already.
// Errors of many steps add up, differently on each processor.
TEST_P(CurvesByMethod, ASheetInAGustIsExactToTheOrder) {
  const Gust gust({.mean = {0, 0, 5}, .intensity = 0.4, .time_scale = 0.6, .seed = 2});
  constexpr double c = 1.2 * 1.5 / (2 * 0.2), end = 0.3;
  constexpr int steps = 30000;
  const auto acceleration = [&](double time, double v) {
    const double w = gust.at(time).z() - v;
    return c * w * std::abs(w);
  };
  double x = 0, v = 0;
  for (int i = 0; i < steps; ++i) {
    const double h = end / steps, time = i * h;
    const double a1 = acceleration(time, v), a2 = acceleration(time + h / 2, v + h / 2 * a1),
                 a3 = acceleration(time + h / 2, v + h / 2 * a2),
                 a4 = acceleration(time + h, v + h * a3);
    x += h * v + h * h / 6 * (a1 + a2 + a3);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  expect_order({"material.cloth.normal_drag=1.5",
                "world.wind={ mean = [0, 0, 5], intensity = 0.4, time_scale = 0.6, seed = 2 }"},
               x, 500);
}

// Mass damping sets in at 0.1237 s: v' = -d v from then on.
TEST_P(CurvesByMethod, DampingThatSetsInIsExactToTheOrder) {
  constexpr double jump = 0.1237, end = 0.3, d = 5;
  const double exact = jump + (1 - std::exp(-d * (end - jump))) / d;
  expect_order({"body.sheet.velocity=[0, 0, 1]",
                "material.cloth.mass_damping={ times = [0, 0.1237], values = [0, 5], "
                "between = \"step\" }"},
               exact);
}

// A pulse of a millisecond gives a body at rest the speed 0.5 * 1e-3 s * 400 m/s^2: steps that
// have grown long do not leap over it, which would lose all of it.
TEST_P(CurvesByMethod, AShortPulseIsNotMissed) {
  constexpr double impulse = 0.2, middle = 0.2005;
  const std::vector<double> of =
      errors({"world.gravity={ times = [0.2, 0.2005, 0.201], values = [[0, 0, 0], [0, 0, 400], "
              "[0, 0, 0]] }"},
             impulse * (0.3 - middle));
  for (const double error : of) EXPECT_LT(error, 0.01 * impulse * (0.3 - middle));
}

// Corners close to each other and far apart, of a force that the error control hardly notices.
TEST_P(CurvesByMethod, AStepEndsAtEveryCorner) {
  for (const char* between : {"linear", "smooth", "step"}) {
    Overrides overrides = GetParam().overrides;
    overrides.emplace_back(GetParam().refinements[0]);
    overrides.push_back(
        "world.gravity={ times = [0, 0.05, 0.0501, 0.0502, 0.06, 0.0601, 0.15, 0.25], values = "
        "[[0,0,0], [1e-6,0,0], [0,0,0], [1e-6,0,0], [0,0,0], [1e-6,0,0], [0,0,0], [1e-6,0,0]], "
        "between = \"" +
        std::string(between) + "\" }");
    SimulatedCase sim(free_sheet, overrides);
    std::vector<double> ends;
    while (sim.integrator().time() < 0.3) {
      ASSERT_FALSE(sim.integrator().step());
      ends.push_back(sim.integrator().time());
    }
    for (const double corner : {0.05, 0.0501, 0.0502, 0.06, 0.0601, 0.15, 0.25}) {
      EXPECT_TRUE(
          std::ranges::any_of(ends, [&](double end) { return std::abs(end - corner) < 1e-12; }))
          << corner << between;
    }
  }
}

TEST_P(CurvesByMethod, StepsFollowAGust) {
  Overrides overrides = GetParam().overrides;
  overrides.emplace_back(GetParam().refinements[0]);
  // Air so thin that the error control does not notice it.
  for (const char* each : {"world.wind={ mean = [5, 0, 0], intensity = 0.3, time_scale = 0.2 }",
                           "material.cloth.normal_drag=1e-9"})
    overrides.emplace_back(each);
  SimulatedCase sim(free_sheet, overrides);
  const double longest = SceneCurves(sim.scene().source).longest_step();
  EXPECT_NEAR(longest, 0.0193 * 0.2, 1e-4 * 0.2);
  double time = 0;
  while (time < 0.3) {
    ASSERT_FALSE(sim.integrator().step());
    EXPECT_LE(sim.integrator().time() - time, longest * (1 + 1e-9));
    time = sim.integrator().time();
  }
}

// Two materials, of which the first varies.
constexpr const char* two_sheets = R"(
[time]
duration = 1
[world]
gravity = { times = [0, 1], values = [[0, 0, 0], [1, 2, 3]] }
wind = { times = [0, 1], values = [[4, 0, 1], [0, 3, 2]] }
air_density = { times = [0, 1], values = [1, 1.3] }
[contact]
enabled = false
[material.cloth]
membrane_stiffness = 50
bending_stiffness = 0.01
mass_damping = { times = [0, 1], values = [0, 3] }
stiffness_damping = { times = [0, 1], values = [0.2, 0], between = "smooth" }
bending_damping = { times = [0, 0.5], values = [0, 0.3], between = "step" }
normal_drag = { times = [0, 1], values = [0, 2] }
tangential_drag = { times = [0, 1], values = [0.5, 0] }
[material.other]
membrane_stiffness = 20
mass_damping = 1
[[body]]
name = "one"
material = "cloth"
shape = { type = "rectangle", size = [1, 1], resolution = [4, 4] }
[[body]]
name = "two"
material = "other"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
position = [2, 0, 0]
)";

// Overrides that give the case the numbers of one time.
Overrides frozen_at(double time) {
  const double smooth = time * time * time * (10 + time * (6 * time - 15));
  const auto set = [](const std::string& key, double value) {
    char number[40];
    std::snprintf(number, sizeof number, "%.17g", value);
    return key + '=' + number;
  };
  char wind[120];
  std::snprintf(wind, sizeof wind, "world.wind=[%.17g, %.17g, %.17g]", 4 - 4 * time, 3 * time,
                1 + time);
  char gravity[120];
  std::snprintf(gravity, sizeof gravity, "world.gravity=[%.17g, %.17g, %.17g]", time, 2 * time,
                3 * time);
  return {wind,
          gravity,
          set("world.air_density", 1 + 0.3 * time),
          set("material.cloth.mass_damping", 3 * time),
          set("material.cloth.stiffness_damping", 0.2 - 0.2 * smooth),
          set("material.cloth.bending_damping", time < 0.5 ? 0 : 0.3),
          set("material.cloth.normal_drag", 2 * time),
          set("material.cloth.tangential_drag", 0.5 - 0.5 * time)};
}

// A state out of the plane, in motion.
std::vector<double> moving_state(const Dynamics& dynamics) {
  std::vector<double> y = dynamics.initial_state();
  auto* const x = reinterpret_cast<Vec3*>(y.data());
  Vec3* const v = x + dynamics.particle_count();
  for (int i = 0; i < dynamics.particle_count(); ++i) {
    x[i].z() += 0.05 * std::sin(5 * x[i].x() + 3 * x[i].y());
    v[i] = Vec3(std::sin(3.0 * i), std::cos(2.0 * i), std::sin(1.0 + i));
  }
  return y;
}

std::vector<Vec3> product(const BlockMatrix& matrix, const std::vector<Vec3>& in) {
  std::vector<Vec3> out(in.size());
  matrix.multiply(in, out, 1);
  return out;
}

double distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum);
}

class CurvesOfForces : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Both, CurvesOfForces, testing::Values("triangles", "springs"),
                         [](const auto& one) { return one.param; });

// Accelerations and matrices at a time are those of a case with that time's constants.
TEST_P(CurvesOfForces, HaveTheCoefficientsOfTheTime) {
  const std::string model = "material.cloth.membrane=\"" + GetParam() + '"';
  SimulatedCase varying(two_sheets, {model});
  Dynamics& of = varying.dynamics();
  const std::vector<double> y = moving_state(of);
  const std::vector<Vec3> along(of.particle_count(), Vec3(1, -2, 0.5));
  std::vector<Vec3> a(of.particle_count()), b(of.particle_count());
  for (const double time : {0.25, 0.75, 0.25}) {
    Overrides overrides = frozen_at(time);
    overrides.push_back(model);
    SimulatedCase frozen(two_sheets, overrides);
    ASSERT_FALSE(of.acceleration(time, y, a));
    ASSERT_FALSE(frozen.dynamics().acceleration(time, y, b));
    EXPECT_LT(distance(a, b), 1e-12 * distance(b, std::vector<Vec3>(b.size(), Vec3::Zero())));
    ForceParts parts, frozen_parts;
    of.find_force_parts(time, y, parts);
    frozen.dynamics().find_force_parts(time, y, frozen_parts);
    EXPECT_LT(distance(parts.own, frozen_parts.own), 1e-12);
    of.assemble(time, y);
    frozen.dynamics().assemble(time, y);
    EXPECT_LT(distance(product(of.damping(), along), product(frozen.dynamics().damping(), along)),
              1e-12);
    EXPECT_LT(
        distance(product(of.stiffness(), along), product(frozen.dynamics().stiffness(), along)),
        1e-9);
  }
}

// The damping matrix is minus the derivative of the forces by the velocities. Drag is symmetric and
// exact along its wind only, so the sheets lie across the wind and move with it.
TEST_P(CurvesOfForces, HaveTheDampingMatrixOfTheTime) {
  SimulatedCase sim(two_sheets, {"material.cloth.membrane=\"" + GetParam() + '"',
                                 "world.wind={ times = [0, 1], values = [[0, 0, 4], [0, 0, 9]] }"});
  Dynamics& of = sim.dynamics();
  const std::vector<double> y = of.initial_state();
  const int count = of.particle_count();
  std::vector<Vec3> along(count), plus(count), minus(count), difference(count);
  for (int i = 0; i < count; ++i) along[i] = Vec3(std::sin(2.0 * i), std::cos(1.0 * i), 1);
  std::vector<std::vector<Vec3>> products;
  for (const double time : {0.25, 0.75}) {
    constexpr double step = 1e-5;
    const auto acceleration = [&](double factor, std::vector<Vec3>& into) {
      std::vector<double> moved = y;
      auto* const v = reinterpret_cast<Vec3*>(moved.data()) + count;
      for (int i = 0; i < count; ++i) v[i] += factor * along[i];
      ASSERT_FALSE(of.acceleration(time, moved, into));
    };
    acceleration(step, plus);
    acceleration(-step, minus);
    for (int i = 0; i < count; ++i)
      difference[i] = sim.scene().mass[i] / (-2 * step) * (plus[i] - minus[i]);
    of.assemble(time, y);
    products.push_back(product(of.damping(), along));
    const double size = distance(difference, std::vector<Vec3>(count, Vec3::Zero()));
    EXPECT_LT(distance(products.back(), difference), 1e-6 * size) << time;
  }
  EXPECT_GT(distance(products[0], products[1]), 0.1);
}

// A block slides down a slope; friction sets in later and stops it. Skipping friction because it is
// zero at the start would let it slide on.
constexpr const char* slope = R"(
[time]
duration = 0.6
[world]
gravity = [2, 0, -9.6]
[contact]
range = 0.004
friction = { times = [0, 0.2], values = [0, 1], between = "step" }
[material.cloth]
membrane_stiffness = 200
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.004]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [3, 3] }
[[obstacle]]
name = "slope"
shape = { type = "rectangle", size = [2, 2], resolution = [3, 3] }
)";

TEST(Curves, FrictionThatSetsInStopsASlide) {
  SimulatedCase sim(slope);
  const auto velocity = [&](double time) {
    const std::vector<double> y = sim.advance_to(time);
    return StateView::of(y).velocity[4].x();
  };
  EXPECT_NEAR(velocity(0.2), 0.4, 0.01);
  // It is slowed by about 9.6 - 2 m/s^2 and stands after 0.053 s.
  EXPECT_LT(std::abs(velocity(0.4)), 0.01);
}

// The sheet is at rest until its weight sets in, which is so large that a step as long as the first
// one of the run would fail its error test.
TEST(Curves, TheFirstStepAfterAJumpIsAsLongAsTheRateAllows) {
  SimulatedCase sim(free_sheet,
                    method("cvode", {"world.gravity={ times = [0, 0.1237], values = "
                                     "[[0, 0, 0], [0, 0, -1e5]], between = \"step\" }"}));
  sim.advance_to(0.1237);
  EXPECT_EQ(sim.integrator().time(), 0.1237);
  ASSERT_FALSE(sim.integrator().step());
  EXPECT_EQ(sim.integrator().counts().error_test_failures, 0);
  EXPECT_LT(sim.integrator().last_step(), 1e-4);
}

TEST(Curves, WhatIsZeroOnlyAtTheStartIsNotSkipped) {
  SimulatedCase sim(two_sheets);
  EXPECT_TRUE(sim.dynamics().has_damping());
  EXPECT_TRUE(sim.dynamics().has_external_forces());
  // Zero at all times is skipped, however it is written.
  const std::string zero = "={ times = [0, 1], values = [0, 0] }";
  Overrides overrides{"material.other.mass_damping=0", "world.gravity=[0, 0, 0]"};
  for (const char* key :
       {"mass_damping", "stiffness_damping", "bending_damping", "normal_drag", "tangential_drag"})
    overrides.push_back(std::string("material.cloth.") + key + zero);
  SimulatedCase none(two_sheets, overrides);
  EXPECT_FALSE(none.dynamics().has_damping());
  EXPECT_FALSE(none.dynamics().has_external_forces());
  EXPECT_FALSE(none.dynamics().varies());
  EXPECT_NE(describe_scene(none.scene()).find("skipped drag and wind: every drag"),
            std::string::npos);
}

TEST(Curves, CheckPrintsEachInALine) {
  const std::string text = describe_scene(*build_scene(parse_case(
      two_sheets, "test.toml",
      {"contact.friction={ times = [0.5, 2], values = [0, 0.4], between = \"smooth\" }",
       "world.gravity={ times = [0, 1, 2.5], values = [[0,0,0], [0,0,-9.81], [1,0,0]], "
       "between = \"step\" }",
       "world.wind={ mean = [5, 0, 0], intensity = 0.2, time_scale = 1.5, seed = 7 }"})));
  for (const char* line :
       {"varies    world.gravity: from [0, 0, 0] to [1, 0, 0], in steps between 0, 1 and 2.5 s\n",
        "varies    world.wind: gusts about [5, 0, 0] m/s, intensity 0.2, time scale 1.5 s, seed "
        "7\n",
        "varies    world.air_density: from 1 to 1.3, straight between 0 and 1 s\n",
        "skipped contact.friction: from 0 to 0.4, eased between 0.5 and 2 s; contact.enabled is "
        "false\n",
        "varies    material.cloth.mass_damping: from 0 to 3, straight between 0 and 1 s\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

// The resolved case is the same case, and its own resolved case.
TEST(Curves, AreKeptByTheResolvedCase) {
  for (const Overrides& overrides :
       {Overrides{}, Overrides{"world.wind={ mean = [5, 0.1, 0], intensity = 0.2, time_scale = 2, "
                               "seed = 3 }"}}) {
    const Case source = parse_case(two_sheets, "test.toml", overrides);
    const Case again = parse_case(source.resolved_text, "test.toml");
    EXPECT_EQ(source.resolved_text, again.resolved_text);
    const Instant now{0.3, 0.3};
    EXPECT_EQ(TimeCurve<Vec3>(source.world.wind).at(now),
              TimeCurve<Vec3>(again.world.wind).at(now));
    EXPECT_EQ(TimeCurve<double>(source.material[0].stiffness_damping).at(now),
              TimeCurve<double>(again.material[0].stiffness_damping).at(now));
  }
}

TEST(Curves, AreReachedByOverrides) {
  const auto wind_at = [](const Overrides& overrides, double time) {
    const Case source = parse_case(two_sheets, "test.toml", overrides);
    return TimeCurve<Vec3>(source.world.wind).at({time, time});
  };
  EXPECT_EQ(wind_at({"world.wind=[1, 2, 3]"}, 0.5), Vec3(1, 2, 3));
  EXPECT_EQ(wind_at({"world.wind.values=[[0,0,0], [2,0,0]]"}, 0.5), Vec3(1, 0, 0));
  EXPECT_EQ(wind_at({"world.wind.values.0=[2, 0, 0]"}, 0), Vec3(2, 0, 0));
  EXPECT_EQ(wind_at({"world.wind.values.1.2=7"}, 1), Vec3(0, 3, 7));
  EXPECT_EQ(wind_at({"world.wind.times.1=2"}, 2), Vec3(0, 3, 2));
  EXPECT_EQ(wind_at({"world.wind.between=step"}, 0.5), Vec3(4, 0, 1));
  const Case source =
      parse_case(two_sheets, "test.toml",
                 {"contact.friction={ times = [0, 1], values = [0, 1] }",
                  "contact.friction.values.1=0.5", "world.gravity.times=[0, 1]",
                  "world.gravity.values=[[0,0,0], [0,0,-9]]", "world.gravity.values.1.2=-8",
                  "world.wind={ mean = [5, 0, 0], intensity = 0.2, time_scale = 1 }",
                  "world.wind.seed=5", "world.wind.mean.0=6"});
  EXPECT_EQ(source.contact.friction.curve()->values[1], 0.5);
  EXPECT_EQ(source.world.gravity.curve()->values[1], Vec3(0, 0, -8));
  EXPECT_EQ(source.world.wind.gust()->seed, 5);
  EXPECT_EQ(source.world.wind.gust()->mean, Vec3(6, 0, 0));
}

// A flag in gusts, under gravity that jumps, with damping that varies: everything that a saved
// state may forget.
TEST(Curves, ASavedStateGoesOnWithTheSameBits) {
  const Overrides curves{
      "material.cloth.density=0.1",
      "body.sheet.pin=[{edges=[\"first_col\"]}]",
      "material.cloth.normal_drag=1",
      "world.wind={ mean = [5, 1, 0], intensity = 0.3, time_scale = 0.5 }",
      "world.gravity={ times = [0, 0.1, 0.2], values = [[0,0,-9], [0,0,-2], [0,0,-9]], "
      "between = \"step\" }",
      "material.cloth.stiffness_damping={ times = [0, 0.3], values = [1e-3, 2e-3] }",
      "material.cloth.mass_damping={ times = [0.05, 0.25], values = [0, 1] }"};
  for (Overrides overrides : {method("euler"), method("euler", {"time.step=3e-3"}),
                              method("implicit_midpoint", {"time.step=3e-3"}), method("verlet")}) {
    const std::string name = overrides[0];
    overrides.insert(overrides.end(), curves.begin(), curves.end());
    const Case source = parse_case(free_sheet, "test.toml", overrides);
    Simulation whole = make_simulation(source);
    // A time of a jump, too: the side on which the state lies must be kept.
    for (const double saved_at : {0.1, 0.15}) {
      Simulation first = make_simulation(source);
      while (first.time() < saved_at) ASSERT_FALSE(first.step()) << name;
      Simulation second = make_simulation(source);
      second.restore(first.save());
      for (int i = 0; i < 40; ++i) {
        ASSERT_FALSE(first.step()) << name;
        ASSERT_FALSE(second.step()) << name;
      }
      EXPECT_EQ(first.time(), second.time()) << name;
      EXPECT_TRUE(std::ranges::equal(first.state(), second.state())) << name << saved_at;
    }
  }
}

TEST(Curves, HaveNoTimeInAnEquilibrium) {
  const Overrides pinned = method("static", {"body.sheet.pin=[{edges=[\"first_col\"]}]"});
  for (const char* curve : {"world.gravity={ times = [0, 1], values = [[0,0,0], [0,0,-9]] }",
                            "material.cloth.mass_damping={ times = [0, 1], values = [0, 1] }",
                            "world.wind={ mean = [5, 0, 0], intensity = 0.2, time_scale = 1 }"}) {
    Overrides overrides = pinned;
    overrides.emplace_back(curve);
    EXPECT_THROW(parse_case(free_sheet, "test.toml", overrides), CaseError) << curve;
  }
  // Equal values are a constant.
  Overrides constant = pinned;
  constant.emplace_back("world.gravity={ times = [0, 1], values = [[0,0,-9], [0,0,-9]] }");
  SimulatedCase sim(free_sheet, constant);
  sim.advance_to(1);
}

// Explicit steps that the damping at the start allows would be unstable later, which the energy
// watch would notice. With d = 6e4 /s^2 (t - 0.05 s) the speed falls as exp(-3e4 (t - 0.05 s)^2).
TEST(Curves, VerletFollowsDampingThatGrows) {
  Simulation sim = make_simulation(parse_case(
      free_sheet, "test.toml",
      method("verlet",
             {"body.sheet.velocity=[1, 0, 0]",
              "material.cloth.mass_damping={ times = [0.05, 0.1], values = [0, 3000] }"})));
  const double start = sim.position("sheet")[4].x();
  const auto failure = sim.advance(0.3);
  ASSERT_FALSE(failure) << failure->text;
  EXPECT_NEAR(sim.position("sheet")[4].x() - start, 0.05 + 0.5 * std::sqrt(std::numbers::pi / 3e4),
              1e-5);
}

}  // namespace
}  // namespace weft::sim::curves_test
