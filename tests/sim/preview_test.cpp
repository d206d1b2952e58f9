// Linearly implicit steps of any length keep surfaces apart and gain no energy.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>

#include "sim/motion/external_work.h"
#include "sim/simulation/simulation.h"
#include "simulated_case.h"

namespace weft::sim::preview_test {
namespace {

const std::string cloth = R"(
[contact]
friction = 0.3
[material.cloth]
density = 0.2
membrane_stiffness = 250
poisson_ratio = 0.3
bending_stiffness = 2e-5
stiffness_damping = 1e-3
bending_damping = 1e-3
)";

// A sheet falls on a ball and drapes over it.
const std::string drape = cloth + R"(
[[body]]
name = "sheet"
position = [0.0, 0.0, 0.3]
thickness = 0.002
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [13, 13] }
[[obstacle]]
name = "ball"
thickness = 0.002
shape = { type = "sphere", radius = 0.25, resolution = [13] }
)";

// Two opposite edges of a sheet turn against each other.
const std::string twist = cloth + R"(
[[body]]
name = "sheet"
thickness = 0.002
shape = { type = "rectangle", size = [0.4, 0.8], resolution = [9, 17] }
[[body.pin]]
edges = ["first_row"]
[[body.pin]]
edges = ["last_row"]
motion = { angular_velocity_deg = [0, 180, 0] }
)";

// A sheet is thrown at a ball.
std::string impact(int resolution, const std::string& place) {
  const std::string count = std::to_string(resolution);
  return cloth + R"(
[[body]]
name = "sheet"
position = )" +
         place + R"(
velocity = [0, 0, -10]
thickness = 0.002
shape = { type = "rectangle", size = [0.6, 0.6], resolution = [)" +
         count + ", " + count + R"(] }
[[obstacle]]
name = "ball"
thickness = 0.002
shape = { type = "sphere", radius = 0.15, resolution = [)" +
         std::to_string(resolution * 2 / 3 + 1) + R"(] }
)";
}

// A sheet spins in space: an edge that moves on a straight line within a step is stretched, and
// steps of 5 ms must be cut.
const std::string spin = cloth + R"(
[world]
gravity = [0, 0, 0]
[[body]]
name = "sheet"
position = [0, 0, 0.3]
angular_velocity_deg = [0, 0, 1500]
shape = { type = "rectangle", size = [0.15, 0.1], resolution = [9, 9] }
)";

// A plane below the sheet, out of reach, that may move.
std::string plane(const std::string& motion) {
  return R"(
[[obstacle]]
name = "plane"
shape = { type = "plane", size = [1, 1] }
)" + motion;
}

struct Preview {
  double gained = 0;   // largest energy beyond what was put in, J
  double most = 0;     // largest kinetic energy, J
  double stretch = 0;  // largest stretch
  int crossings = 0;   // at accepted steps
  IntegratorCounts counts;
};

// Runs a scene with `newton` corrections a step. The energy is that of motion and strain, as in
// EnergyWatch: energy of contact counts once it has become motion.
Preview run(const std::string& scene, double step, double duration, int newton = 1) {
  const std::unique_ptr<const Scene> compiled = build_scene(
      parse_case(scene, "preview.toml",
                 method("euler", {"time.newton=" + std::to_string(newton), key("step", step)})));
  Simulation simulation(*compiled);
  Dynamics& dynamics = simulation.dynamics();
  Statistics statistics;
  Dynamics apart(*compiled, statistics);  // measures without touching the simulation
  ExternalWork work(apart, simulation.state());
  const auto energy = [&](const Energies& now) { return now.total() - now.contact; };
  const double start = energy(apart.energies(0, simulation.state()));
  Preview preview;
  std::vector<Vec3> position, velocity;
  while (simulation.time() < duration) {
    if (const auto failure = simulation.step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    const double time = simulation.time();
    const std::span<const double> state = simulation.state();
    work.add_step(time, state);
    const Energies now = apart.energies(time, state);
    const double put_in = start + work.work() + work.doubt() + work.held_kinetic_energy() +
                          work.held_gravitational_energy();
    preview.gained = std::max(preview.gained, energy(now) - put_in);
    preview.most = std::max(preview.most, now.kinetic);
    apart.expand_all(time, state, position, velocity);
    preview.stretch = std::max(preview.stretch, dynamics.largest_stretch(position));
    preview.crossings += crossings(*compiled, position);
  }
  preview.counts = simulation.counts();
  return preview;
}

constexpr std::array steps{1.0 / 30, 1.0 / 60, 1.0 / 120, 1.0 / 240};

TEST(Preview, DrapesWithoutCrossingsAndGainsNoEnergy) {
  for (const double step : steps) {
    const Preview preview = run(drape, step, 0.5);
    EXPECT_EQ(preview.crossings, 0) << step;
    // Sheets that start a micrometre apart have none, one or two cuts. Stops that pull cost ten.
    EXPECT_LE(preview.counts.vetoed_steps, 3) << step;
    EXPECT_LE(preview.gained, 0.002 * preview.most) << step;
    EXPECT_LT(preview.stretch, 0.16) << step;
  }
}

TEST(Preview, TwistsWithoutCrossingsAndGainsNoEnergy) {
  for (const double step : steps) {
    const Preview preview = run(twist, step, 0.5);
    EXPECT_EQ(preview.crossings, 0) << step;
    EXPECT_LE(preview.gained, 0.002 * preview.most) << step;
  }
}

// With several stops for each point, some of which pull, the finer sheet gains 2.7 %.
TEST(Preview, SurvivesAnImpactWithoutCrossingsAndGainsNoEnergy) {
  const std::array scenes{impact(13, "[0.02, 0.01, 0.4]"), impact(25, "[0, 0, 0.4]")};
  // In 1/30 s this sheet moves by half its size: such steps are cut until they are no preview.
  for (const double step : std::span(steps).subspan(1)) {
    for (const std::string& scene : scenes) {
      const Preview preview = run(scene, step, 0.15);
      EXPECT_EQ(preview.crossings, 0) << step;
      EXPECT_LE(preview.gained, 0.002 * preview.most) << step;
    }
  }
}

// A motion that touches nothing does no work: steps that gain energy are cut beside it, too.
TEST(Preview, SpinsBesideAMovingObstacleAndGainsNoEnergy) {
  const Preview still = run(spin + plane(""), 0.005, 0.09);
  EXPECT_GT(still.counts.convergence_failures, 0);
  for (const char* motion : {"motion = { velocity = [0, 0, -1] }",
                             "motion = { velocity = [0, 0, -1], start_time = 0.03 }"}) {
    SCOPED_TRACE(motion);
    const Preview preview = run(spin + plane(motion), 0.005, 0.09);
    EXPECT_LE(preview.gained, 0.01 * preview.most);
    EXPECT_LT(preview.stretch, 0.1);
  }
  const Preview later =
      run(spin + plane("motion = { velocity = [0, 0, -1], start_time = 0.1 }"), 0.005, 0.09);
  EXPECT_EQ(later.counts.steps, still.counts.steps);
  EXPECT_EQ(later.gained, still.gained);
}

// Drag in still air only takes energy: steps that gain some are cut in air, too.
TEST(Preview, SpinsInAirAndGainsNoEnergy) {
  std::string in_air = spin;
  in_air.insert(in_air.find("density"), "normal_drag = 1e-3\n");
  const Preview preview = run(in_air + plane(""), 0.005, 0.09);
  EXPECT_GT(preview.counts.convergence_failures, 0);
  EXPECT_LE(preview.gained, 0.01 * preview.most);
  EXPECT_LT(preview.stretch, 0.1);
}

// The work of loads and wind is no gain of energy: steps are not cut for it.
TEST(Preview, TakesWholeStepsUnderLoadsAndInWind) {
  std::string still = spin;
  still.replace(still.find("1500"), 4, "0");
  std::string in_wind = still;
  in_wind.insert(in_wind.find("density"), "normal_drag = 1\n");
  in_wind.insert(in_wind.find("gravity"), "wind = [0, 0, 10]\n");
  const std::string load = "[[load]]\nbody = \"sheet\"\ntype = \"area\"\nforce = [0, 0, 2]\n";
  for (const std::string& scene : {still + plane("") + load, in_wind + plane("")}) {
    const Preview preview = run(scene, 1.0 / 60, 0.5);
    EXPECT_GT(preview.most, 1e-3) << scene;
    EXPECT_EQ(preview.counts.convergence_failures, 0) << scene;
    EXPECT_LE(preview.gained, 0.01 * preview.most) << scene;
  }
}

// Steps of 1/60 s bring this sheet close to the ball without a meeting. Ended there, in a tenth of
// the range, they would store three times the energy of its fall.
TEST(Preview, EndsNoStepDeepInABarrier) {
  const std::string scene = R"(
[material.cotton]
density = 0.2
membrane_stiffness = 1000
bending_stiffness = 1e-5
stiffness_damping = 1e-3
normal_drag = 1.0
[[body]]
name = "cloth"
position = [0.0, 0.0, 0.32]
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [33, 33] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.3, resolution = [17] }
)";
  for (const double step : steps) {
    const Preview preview = run(scene, step, 0.2);
    EXPECT_EQ(preview.crossings, 0) << step;
    EXPECT_LE(preview.gained, 0.005 * preview.most) << step;
  }
}

// The barrier alone slows this sheet down, within a fifth of the range. By short steps, the room of
// a stop is passed at far more than the speed of the sheet, so that a stop would pull at it.
TEST(Preview, GainsNoEnergyByShortSteps) {
  const std::string scene = R"(
[world]
gravity = [0, 0, 0]
[contact]
stiffness = 1e5
[material.felt]
density = 2.0
membrane_stiffness = 10000
bending_stiffness = 1e-2
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
position = [0, 0, 0.0045]
velocity = [0, 0, -1.5]
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [4, 4] }
)";
  for (const double step : {1e-3, 1e-4, 1e-5}) {
    const Preview preview = run(scene, step, 0.006);
    EXPECT_EQ(preview.counts.convergence_failures, 0) << step;
    EXPECT_EQ(preview.counts.steps, std::lround(0.006 / step)) << step;
    EXPECT_LE(preview.gained, 1e-9 * preview.most) << step;
  }
}

// A hanging sheet that a ball pushes takes hardly more than one correction a step. A correction
// that knew only the end of the ball's way would have to be repeated, and most steps halved.
TEST(Preview, IsPushedByAnObstacle) {
  const std::string scene = cloth + R"(
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
rotation_deg = [90, 0, 0]
pin = [{ corners = ["last_first", "last_last"] }]
[[obstacle]]
name = "ball"
position = [0, -0.25, 0]
shape = { type = "sphere", radius = 0.2, resolution = [17] }
motion = { velocity = [0, 1, 0], stop_time = 0.15 }
)";
  for (const double step : {1.0 / 60, 1.0 / 240}) {
    const Preview preview = run(scene, step, 0.2);
    EXPECT_EQ(preview.crossings, 0) << step;
    EXPECT_LE(preview.gained, 0.01 * preview.most) << step;
    EXPECT_LT(preview.stretch, 0.25) << step;
    EXPECT_LT(10 * preview.counts.newton_iterations, 11 * preview.counts.steps) << step;
    EXPECT_LT(preview.counts.vetoed_steps + preview.counts.convergence_failures, 5) << step;
  }
}

// A plate throws a sheet: it flies on from where the plate slows down by more than g.
TEST(Preview, IsThrownByAPlate) {
  const double way = 0.2, duration = 0.2;  // of the plate, m and s
  const auto acceleration = [&](double part) {
    return way / (duration * duration) * part * (60 - part * (180 - 120 * part));
  };
  double early = 0.5, late = 0.75;
  for (int i = 0; i < 50; ++i) {
    const double part = 0.5 * (early + late);
    (acceleration(part) > -9.81 ? early : late) = part;
  }
  const double place = way * std::pow(early, 3) * (10 - early * (15 - 6 * early));
  const double speed = way / duration * 30 * std::pow(early * (1 - early), 2);
  for (const double step : {0.005, 1e-3}) {
    SimulatedCase sim(cloth + R"(
[[body]]
name = "sheet"
position = [0, 0, 0.00285]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[obstacle]]
name = "plate"
shape = { type = "plane", size = [1, 1] }
motion = { keyframes = [{ time = 0, translation = [0, 0, 0] },
                        { time = 0.2, translation = [0, 0, 0.2] }] }
)",
                      method("euler", {"time.newton=1", key("step", step)}));
    const double flight = speed / 9.81;
    const std::vector<Vec3> position = sim.positions_at(early * duration + flight);
    double height = 0;
    for (int i = 0; i < sim.scene().dynamic_particles; ++i) height += position[i].z() / 25;
    EXPECT_NEAR(height - 0.00285, place + 0.5 * speed * flight, 2e-3) << step;
    const IntegratorCounts& counts = sim.integrator().counts();
    EXPECT_LE(10 * counts.newton_iterations, 12 * counts.steps);
  }
}

// Pins twist a tube with two balls inside. Corrections with the derivative of friction, which is
// zero where it slides, would throw vertices about.
TEST(Preview, GainsNoEnergyBySeveralCorrections) {
  const std::string scene = R"(
[contact]
friction = 0.3
[material.cloth]
density = 0.2
membrane_stiffness = 1000
bending_stiffness = 1e-5
stiffness_damping = 1e-3
bending_damping = 1e-3
[[body]]
name = "tube"
shape = { type = "cylinder", radius = 0.1, length = 0.4, resolution = [13, 21] }
[[body.pin]]
edges = ["first_row"]
motion = { angular_velocity_deg = [0, 0, -300] }
[[body.pin]]
edges = ["last_row"]
motion = { angular_velocity_deg = [0, 0, 300], velocity = [0, 0, -0.1] }
[[particles]]
name = "balls"
radius = 0.03
density = 500
positions = { type = "grid", count = [1, 1, 2], spacing = 0.08, centre = [0, 0, 0] }
)";
  for (const int newton : {2, 4}) {
    const Preview preview = run(scene, 1.0 / 60, 0.2, newton);
    EXPECT_EQ(preview.crossings, 0) << newton;
    EXPECT_LE(preview.gained, 0.05 * preview.most) << newton;
    EXPECT_LT(preview.counts.steps, 40) << newton;
  }
}

// Steps in which pins pull are cut where they gain more energy than the pins give.
TEST(Preview, IsPulledThroughARingAndGainsNoEnergy) {
  std::ifstream file(WEFT_CASES_DIR "/benchmarks/pulled_through_ring.toml");
  const std::string scene(std::istreambuf_iterator<char>(file), {});
  for (const double step : steps) {
    const Preview preview = run(scene, step, 0.1);
    EXPECT_EQ(preview.crossings, 0) << step;
    EXPECT_LE(preview.gained, 0.1 * preview.most) << step;
  }
}

}  // namespace
}  // namespace weft::sim::preview_test
