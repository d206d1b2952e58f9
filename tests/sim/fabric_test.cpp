// Cloth that differs by direction, and the presets of measured fabrics, in whole scenes.
#include <cmath>
#include <numbers>

#include "bench/membrane_measures.h"
#include "sim/forces/force_arrays.h"
#include "simulated_case.h"
#include "tests/measured_fabrics.h"

namespace weft::sim::fabric_test {
namespace {

// A sheet of 0.2 m x 0.1 m of this material, that starts stretched. Its rows lie along x.
std::string stretched_sheet(const std::string& material, double along, double across,
                            double warp_angle_deg) {
  return "[contact]\nenabled = false\n[world]\ngravity = [0, 0, 0]\n" + material +
         "\n[[body]]\nname = \"sheet\"\nwarp_angle_deg = " + std::to_string(warp_angle_deg) +
         "\nstretch = [" + std::to_string(along) + ", " + std::to_string(across) +
         ", 1]\nshape = { type = \"rectangle\", size = [0.2, 0.1], resolution = [6, 11] }\n";
}

std::array<double, 2> pulls_of(const std::string& text) {
  const auto scene = build_scene(parse_case(text, "test.toml"));
  return bench::membrane_pulls(*scene, scene->initial_position);
}

std::string preset(const std::string& name) {
  return "[material.fabric]\npreset = \"" + name + "\"\n";
}

double green(double stretch) { return 0.5 * (stretch * stretch - 1); }

Case benchmark_case(const std::string& name, const Overrides& overrides = {}) {
  return read_case(WEFT_CASES_DIR "/benchmarks/" + name + ".toml", overrides);
}
Case stretched_fabric(const MeasuredFabric& fabric) {
  return benchmark_case("stretched_fabric", {"material.fabric.preset=\"" + fabric.name + '"'});
}

void expect_published(const MeasuredFabric& fabric, const std::vector<bench::FabricPull>& pulls) {
  ASSERT_EQ(pulls.size(), 4);
  for (const bench::FabricPull& each : pulls) {
    ASSERT_GT(each.published, 0);
    EXPECT_NEAR(each.force, each.published, 0.005 * each.published)
        << fabric.name << ' ' << each.stretch;
  }
}

// Stretched in one direction, with the width held: the force per rest width is stretch x S.
TEST(Fabric, UniaxialStretchHasThePublishedForce) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    for (const double degrees : {0.0, 45.0, 90.0})
      expect_published(fabric, bench::uniaxial_pulls(stretched_fabric(fabric), fabric, degrees));
  }
}

// Stretched alike along warp and weft: the sum of both forces per width is published.
TEST(Fabric, BiaxialStretchHasThePublishedForce) {
  for (const MeasuredFabric& fabric : measured_fabrics())
    expect_published(fabric, bench::biaxial_pulls(stretched_fabric(fabric), fabric));
}

// The force per rest width in the direction of the first stretch, from the work of the tabulated
// law, evaluated anew.
double force_of_law(const MeasuredFabric& fabric, double warp, double weft, bool along_warp) {
  const double step = 1e-6;
  const auto work = [&](double change) {
    return tabulated_work(fabric, green(warp + (along_warp ? change : 0)),
                          green(weft + (along_warp ? 0 : change)), 0);
  };
  return (work(step) - work(-step)) / (2 * step);
}

// Warp and weft each, stretched alike and not alike, have the force of the tabulated law.
TEST(Fabric, BiaxialStretchHasTheForceOfTheTableInBothDirections) {
  const std::vector<std::pair<double, double>> stretches{
      {1.005, 1.005}, {1.03, 1.03}, {1.1, 1.1}, {1.25, 1.25}, {1.05, 1.02}, {1.01, 1.08}};
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    for (const auto& [warp, weft] : stretches) {
      const auto pulls = pulls_of(stretched_sheet(preset(fabric.name), warp, weft, 0));
      const double of_warp = force_of_law(fabric, warp, weft, true);
      const double of_weft = force_of_law(fabric, warp, weft, false);
      EXPECT_NEAR(pulls[0] / 0.1, of_warp, 0.005 * std::abs(of_warp)) << fabric.name << ' ' << warp;
      EXPECT_NEAR(pulls[1] / 0.2, of_weft, 0.005 * std::abs(of_weft)) << fabric.name << ' ' << weft;
    }
  }
}

// The published tensions have no energy. Decision 0040 says by how much either force of an equal
// stretch differs from them.
TEST(Fabric, EitherForceOfABiaxialStretchIsNearThePublishedOne) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    const bool is_woven = fabric.name == "white-dots-on-blk" || fabric.name == "royal-target" ||
                          fabric.name == "11oz-black-denim";
    for (const double stretch : {1.005, 1.03, 1.1}) {
      const double e = green(stretch);
      const auto tension = published_tension(fabric, e, e, 0);
      const auto pulls = pulls_of(stretched_sheet(preset(fabric.name), stretch, stretch, 0));
      const double limit = is_woven ? 0.01 : 0.18;
      EXPECT_NEAR(pulls[0] / 0.1, stretch * tension[0], limit * stretch * tension[0])
          << fabric.name << ' ' << stretch;
      EXPECT_NEAR(pulls[1] / 0.2, stretch * tension[1], limit * stretch * tension[1])
          << fabric.name << ' ' << stretch;
    }
  }
}

// A sheet of 3 x 5 vertices that is pulled along its warp or its weft with free sides.
std::string pulled_sheet(const std::string& fabric, bool along_warp, double stretch) {
  return "[time]\nmethod = \"static\"\nduration = 1\nframes_per_second = 4\n"
         "position_tolerance = 1e-8\n[contact]\nenabled = false\n[world]\ngravity = "
         "[0, 0, 0]\n" +
         preset(fabric) + "bending_stiffness = 0\n[[body]]\nname = \"sheet\"\n" +
         "warp_angle_deg = " + (along_warp ? "0" : "90") +
         "\nshape = { type = \"rectangle\", size = [0.2, 0.1], resolution = [3, 5] "
         "}\n[[body.pin]]\nedges = [\"first_col\"]\naxes = [\"x\", \"z\"]\n"
         "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"y\", \"z\"]\n"
         "[[body.pin]]\nedges = [\"last_row\"]\naxes = [\"z\"]\n"
         "[[body.pin]]\nedges = [\"last_col\"]\naxes = [\"x\", \"z\"]\n"
         "motion = { keyframes = [{ time = 0 }, { time = 1, translation = [" +
         std::to_string(0.2 * (stretch - 1)) + ", 0, 0] }] }\n";
}

// The width takes the least work, and the force is the change of that work. The bar of 1e-4 is
// above the error of the differences, at most 1.2e-5.
void expect_published_work(const MeasuredFabric& fabric, bool along_warp, double stretch) {
  SCOPED_TRACE(fabric.name + (along_warp ? " warp " : " weft ") + std::to_string(stretch));
  SimulatedCase sim(pulled_sheet(fabric.name, along_warp, stretch));
  const std::vector<Vec3> x = sim.positions_at(1);
  const double width = (x[12].y() - x[2].y()) / 0.1;  // of the middle column
  for (int i = 0; i < 15; ++i) {
    const Vec3 uniform(stretch * 0.05 * (i % 5) - 0.1, width * 0.05 * (i / 5) - 0.05, 0);
    EXPECT_LT((x[i] - uniform).norm(), 1e-6) << i;
  }
  const auto work = [&](double pulled, double across) {
    return along_warp ? bench::published_work(fabric, green(pulled), green(across))
                      : bench::published_work(fabric, green(across), green(pulled));
  };
  for (const double change : {1e-3, -1e-3})
    EXPECT_GT(work(stretch, width + change), work(stretch, width));
  const double force = bench::membrane_pulls(sim.scene(), x)[0];
  const double slope = (work(stretch + 1e-4, width) - work(stretch - 1e-4, width)) / 2e-4;
  EXPECT_NEAR(force, slope * 0.1, 1e-4 * force);
}

// Pulled with free sides. At 6 % the energy of three knits is no longer convex: their sheets widen
// or take zigzags.
TEST(Fabric, PullWithFreeSidesTakesThePublishedWork) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    const bool is_convex = fabric.name != "ivory-rib-knit" && fabric.name != "camel-ponte-roma" &&
                           fabric.name != "tango-red-jet-set";
    for (const bool along_warp : {true, false}) {
      expect_published_work(fabric, along_warp, 1.02);
      if (is_convex) expect_published_work(fabric, along_warp, 1.06);
    }
  }
}

// A sheet that is pulled along x by forces on its first and last columns, with free sides. Its rows
// keep their direction; its columns may incline.
std::string freely_pulled_sheet(const std::string& fabric, double warp_angle_deg,
                                double force_per_length) {
  const std::string load = "[[load]]\nbody = \"sheet\"\ntype = \"line\"\n";
  return "[time]\nmethod = \"static\"\nduration = 1\nframes_per_second = 4\n"
         "position_tolerance = 1e-8\n[contact]\nenabled = false\n[world]\ngravity = "
         "[0, 0, 0]\n" +
         preset(fabric) + "bending_stiffness = 0\n[[body]]\nname = \"sheet\"\n" +
         "warp_angle_deg = " + std::to_string(warp_angle_deg) +
         "\nshape = { type = \"rectangle\", size = [0.2, 0.1], resolution = [3, 5] "
         "}\n[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"y\"]\n"
         "[[body.pin]]\ncorners = [\"first_first\"]\naxes = [\"x\"]\n"
         "[[body.pin]]\nrows = [0, -1]\ncols = [0, -1]\naxes = [\"z\"]\n" +
         load + "edges = [\"last_col\"]\nforce = [" + std::to_string(force_per_length) +
         ", 0, 0]\n" + load + "edges = [\"first_col\"]\nforce = [" +
         std::to_string(-force_per_length) + ", 0, 0]\n";
}

// The deformation of the sheet is x = stretch X + lean Y, y = width Y. All three numbers take the
// least work of the tabulated law less that of the force, which is therefore the slope of the work.
void expect_force_of_the_table(const MeasuredFabric& fabric, double degrees) {
  SCOPED_TRACE(fabric.name + " " + std::to_string(degrees));
  const double c = std::cos(degrees * std::numbers::pi / 180),
               s = std::sin(degrees * std::numbers::pi / 180);
  const double e = green(1.01);
  const auto tension = published_tension(fabric, e * c * c, e * s * s, e * c * s);
  const double force = 0.07 * (tension[0] * c * c + tension[1] * s * s + 2 * tension[2] * c * s);
  // The warp lies at -degrees to the pull.
  SimulatedCase sim(freely_pulled_sheet(fabric.name, -degrees, force / 0.1));
  const std::vector<Vec3> x = sim.positions_at(1);
  const double stretch = (x[4].x() - x[0].x()) / 0.2, lean = (x[10].x() - x[0].x()) / 0.1,
               width = (x[10].y() - x[0].y()) / 0.1;
  EXPECT_GT(stretch, 1.002);
  EXPECT_LT(stretch, 1.08);
  for (int i = 0; i < 15; ++i) {
    const double along = 0.05 * (i % 5), up = 0.05 * (i / 5);
    EXPECT_LT((x[i] - x[0] - Vec3(stretch * along + lean * up, width * up, 0)).norm(), 1e-6) << i;
  }
  const auto work = [&](double pulled, double leaning, double across) {
    const double xx = green(pulled), xy = 0.5 * pulled * leaning,
                 yy = 0.5 * (leaning * leaning + across * across - 1);
    // Components in the axes of warp (c, -s) and weft (s, c).
    return tabulated_work(fabric, c * c * xx - 2 * c * s * xy + s * s * yy,
                          s * s * xx + 2 * c * s * xy + c * c * yy,
                          c * s * (xx - yy) + (c * c - s * s) * xy);
  };
  const double step = 1e-5;
  const auto slope = [&](double first, double second, double third) {
    return 0.1 *
           (work(stretch + first, lean + second, width + third) -
            work(stretch - first, lean - second, width - third)) /
           (2 * step);
  };
  EXPECT_NEAR(slope(step, 0, 0), force, 0.005 * force);
  EXPECT_NEAR(slope(0, step, 0), 0, 0.005 * force);
  EXPECT_NEAR(slope(0, 0, step), 0, 0.005 * force);
}

// Each direction by itself, sides free.
TEST(Fabric, PullWithFreeSidesHasTheForceOfTheTableInEveryDirection) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    for (const double degrees : {0.0, 45.0, 90.0}) expect_force_of_the_table(fabric, degrees);
  }
}

constexpr const char* woven = R"([material.woven]
[material.woven.orthotropic_membrane]
warp_stiffness = 800
weft_stiffness = 300
shear_modulus = 15
poisson_ratio = 0.25
)";

// S = C E with C_11 = E_1 / (1 - nu_12 nu_21).
TEST(Fabric, OrthotropicPullsHaveTheirModuli) {
  const double contraction = 1 - 0.25 * 0.25 * 300 / 800.0, e = green(1.02);
  const auto warp = pulls_of(stretched_sheet(woven, 1.02, 1, 0));
  EXPECT_NEAR(warp[0], 0.1 * 1.02 * 800 / contraction * e, 1e-9);
  EXPECT_NEAR(warp[1], 0.2 * 0.25 * 300 / contraction * e, 1e-9);
  const auto weft = pulls_of(stretched_sheet(woven, 1.02, 1, 90));
  EXPECT_NEAR(weft[0], 0.1 * 1.02 * 300 / contraction * e, 1e-9);
  // At 45 degrees: (C_11 + 2 C_12 + C_22) / 4 + G.
  const double bias = (800 + 2 * 0.25 * 300 + 300) / contraction / 4 + 15;
  for (const double degrees : {45.0, -45.0, 135.0})
    EXPECT_NEAR(pulls_of(stretched_sheet(woven, 1.02, 1, degrees))[0], 0.1 * 1.02 * bias * e, 1e-9);
}

TEST(Fabric, CurvesGiveTheirTension) {
  const std::string curved = R"([material.woven.orthotropic_membrane]
weft_stiffness = 300
shear_modulus = 15
[material.woven.orthotropic_membrane.warp_curve]
strains = [-0.2, 0, 0.01, 0.05]
tensions = [-3, 0, 2, 50]
)";
  for (const auto& [stretch, tension] :
       {std::pair{1.005, 1.0}, {1.03, 26.0}, {1.06, 62.0}, {0.9, -1.5}}) {
    EXPECT_NEAR(pulls_of(stretched_sheet(curved, stretch, 1, 0))[0], 0.1 * tension, 1e-9);
    EXPECT_NEAR(pulls_of(stretched_sheet(curved, 1, stretch, 90))[1], 0.2 * tension, 1e-9);
  }
}

// The warp follows the rows of any image; on a tube they go round.
TEST(Fabric, WarpFollowsTheRowsOfCurvedImages) {
  const std::string tube = R"(
[[body]]
name = "tube"
shape = { type = "cylinder", radius = 0.1, length = 0.3, resolution = [9, 16] }
)";
  const auto energy_of = [&](const std::string& stretch, double degrees) {
    const auto scene = build_scene(parse_case(
        "[contact]\nenabled = false\n" + std::string(woven) + tube + "stretch = " + stretch +
            "\nwarp_angle_deg = " + std::to_string(degrees) + "\n",
        "test.toml"));
    const std::vector<Vec3> at_rest(scene->initial_position.size(), Vec3::Zero());
    return make_membrane_force(*scene)->energy({scene->initial_position, at_rest}, 1);
  };
  const double around = energy_of("[1.01, 1.01, 1]", 0), along = energy_of("[1, 1, 1.01]", 0);
  EXPECT_NEAR(around / along, 800.0 / 300, 0.01);
  EXPECT_NEAR(energy_of("[1.01, 1.01, 1]", 90) / along, 1, 0.01);
}

// E h = 900 N/m, nu = 1/3, G h = E h / (2 (1 + nu)) by refinement: the values of two lattices are
// extrapolated to cells of no size.
TEST(Fabric, SpringLatticesHaveTheirConstants) {
  const Case lattice = benchmark_case("spring_lattice");
  const bench::LatticeModuli limit = bench::refined_moduli(lattice, 32);
  EXPECT_NEAR(limit.stretch_stiffness(), 900, 0.9);
  EXPECT_NEAR(limit.poisson_ratio(), 1.0 / 3, 1.0 / 3000);
  EXPECT_NEAR(limit.c66, 900 / (2 * (1 + 1.0 / 3)), 0.34);
  // The error halves with the cells.
  const double coarse = bench::lattice_moduli(lattice, 16).c11,
               fine = bench::lattice_moduli(lattice, 32).c11;
  EXPECT_NEAR((coarse - limit.c11) / (fine - limit.c11), 2, 0.05);
}

// A stretched sheet is let go: without damping its energy stays, and the swing of the energy goes
// with the square of the step.
TEST(Fabric, EnergyIsConserved) {
  for (const char* name : {"gray-interlock", "11oz-black-denim", "pink-ribbon-brown"}) {
    std::array<double, 2> swings{};
    for (const int halvings : {0, 1}) {
      SimulatedCase sim(stretched_sheet(preset(name), 1.04, 1.02, 30) +
                            "rotation_deg = [20, 0, 0]\nvelocity = [0, 0, 0.1]\n[time]\nmethod = "
                            "\"verlet\"\nduration = 0.02\nstep = " +
                            std::to_string(halvings == 0 ? 1e-4 : 5e-5),
                        {});
      std::vector<double> y(sim.integrator().state().begin(), sim.integrator().state().end());
      const double start = sim.energy(0, y);
      for (double time = 1e-3; time < 0.0201; time += 1e-3)
        swings[halvings] =
            std::max(swings[halvings], std::abs(sim.energy(time, sim.advance_to(time)) - start));
      EXPECT_LT(swings[halvings], 0.02 * start) << name;
    }
    EXPECT_NEAR(swings[0] / swings[1], 4, 1.5) << name;
  }
}

// The bending energy (J) of a strip of 0.3 m x 0.1 m, rolled to a cylinder with this radius (m) in
// one of the directions 0 (warp), 1 (bias) and 2 (weft), with cells of size 0.3 m / `cells`.
double rolled_energy(const std::string& fabric, int direction, double radius, int cells) {
  const std::string text =
      "[contact]\nenabled = false\n" + preset(fabric) +
      "[[body]]\nname = \"sheet\"\nwarp_angle_deg = " + std::to_string(-45 * direction) +
      "\nstart = { bend_radius = " + std::to_string(radius) +
      " }\nshape = { type = \"rectangle\", size = [0.3, 0.1], resolution = [" +
      std::to_string(cells / 3 + 1) + ", " + std::to_string(cells + 1) + "] }\n";
  const auto scene = build_scene(parse_case(text, "test.toml"));
  const std::vector<Vec3> at_rest(scene->initial_position.size(), Vec3::Zero());
  return make_bending_force(*scene)->energy({scene->initial_position, at_rest}, 1);
}

// A strip rolled along its warp, its bias and its weft has the energy of the table.
TEST(Fabric, BendingHasTheStiffnessOfItsDirection) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    for (int direction = 0; direction < 3; ++direction) {
      // int_0^K B(k) k dk with B straight between its values at 0 and 10 1/m, and so on.
      const double curvature = 1 / 0.06;
      double exact = 0;
      for (int i = 0; i < 4; ++i) {
        const double from = 10 * i, to = std::min(curvature, from + 10.0);
        if (to <= from) break;
        const double b0 = fabric.bending[direction][i],
                     slope = (fabric.bending[direction][i + 1] - b0) / 10;
        exact += (b0 - slope * from) * (to * to - from * from) / 2 +
                 slope * (to * to * to - from * from * from) / 3;
      }
      exact *= 0.3 * 0.1;
      // Half a cell lacks curvature at the two bent ends, and on the bias the triangles at the
      // sides relax: up to 4.5 % with 60 cells. Both errors go with the size of the cells, and
      // their extrapolation leaves at most 0.1 %.
      const double coarse = rolled_energy(fabric.name, direction, 0.06, 30),
                   fine = rolled_energy(fabric.name, direction, 0.06, 60);
      EXPECT_NEAR(2 * fine - coarse, exact, 0.002 * exact) << fabric.name << ' ' << direction;
    }
  }
}

// Bodies of several kinds of membrane and bending have one energy of each.
TEST(Fabric, SeveralKindsOfClothShareOneForce) {
  const std::string text =
      "[contact]\nenabled = false\n[material.plain]\nbending_stiffness = 1e-5\n" +
      std::string(woven) + preset("11oz-black-denim") + R"(
[[body]]
name = "one"
material = "plain"
stretch = [1.02, 1, 1]
shape = { type = "rectangle", size = [0.2, 0.1], resolution = [6, 11] }
[[body]]
name = "two"
material = "woven"
position = [0, 1, 0]
stretch = [1.02, 1, 1]
shape = { type = "rectangle", size = [0.2, 0.1], resolution = [6, 11] }
[[body]]
name = "three"
material = "fabric"
position = [0, 2, 0]
stretch = [1.02, 1, 1]
shape = { type = "rectangle", size = [0.2, 0.1], resolution = [6, 11] }
)";
  SimulatedCase sim(text);
  int membranes = 0, bendings = 0;
  for (const std::string& name : sim.dynamics().force_names()) {
    membranes += name == "membrane" ? 1 : 0;
    bendings += name == "bending" ? 1 : 0;
  }
  EXPECT_EQ(membranes, 1);
  EXPECT_EQ(bendings, 1);
  double sum = 0;
  for (const std::string& material :
       {std::string("[material.plain]\n"), std::string(woven), preset("11oz-black-denim")}) {
    const auto alone = build_scene(parse_case(stretched_sheet(material, 1.02, 1, 0), "test.toml"));
    const std::vector<Vec3> at_rest(alone->initial_position.size(), Vec3::Zero());
    sum += make_membrane_force(*alone)->energy({alone->initial_position, at_rest}, 1);
  }
  const auto all = make_membrane_force(sim.scene());
  const std::vector<Vec3> at_rest(sim.scene().initial_position.size(), Vec3::Zero());
  EXPECT_NEAR(all->energy({sim.scene().initial_position, at_rest}, 1), sum, 1e-12 * sum);
}

}  // namespace
}  // namespace weft::sim::fabric_test
