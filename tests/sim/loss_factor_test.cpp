// Damping by a measured loss factor, against the decay of free vibrations.
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "bench/cloth_runs.h"
#include "sim/case/case_text.h"
#include "tests/sim/bad_case.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::loss_factor_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double loss_factor = 0.06;

// cases/benchmarks/NAME.toml
std::string text_of(const std::string& name) {
  std::ifstream file(WEFT_CASES_DIR "/benchmarks/" + name + ".toml");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}
// Strips that vibrate in bending at 12.514 Hz, and along themselves at 50 Hz.
const std::string bent_strip = text_of("ring_down_bending"),
                  stretched_strip = text_of("ring_down_membrane");

bench::Decay ring_down(const std::string& text, int axis, const Overrides& overrides = {}) {
  return bench::ring_down(parse_case(text, "test.toml", overrides), axis);
}

}  // namespace

TEST(LossFactor, DampsBendingAsMeasured) {
  const bench::Decay decay = ring_down(bent_strip, 2);
  EXPECT_NEAR(decay.frequency, 12.514, 0.01 * 12.514);
  EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
}

TEST(LossFactor, DampsTheBendingOfShellsAsMeasured) {
  const bench::Decay decay = ring_down(
      bent_strip, 2, {"body.strip.material=\"shell\"", "body.strip.shape.resolution=[4,17]"});
  EXPECT_NEAR(decay.frequency, 12.514, 0.01 * 12.514);
  EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
}

TEST(LossFactor, DampsTheMembraneAsMeasured) {
  const bench::Decay decay = ring_down(stretched_strip, 0);
  EXPECT_NEAR(decay.frequency, 50, 0.01 * 50);
  EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
}

TEST(LossFactor, DampsSpringsAsMeasured) {
  const bench::Decay decay =
      ring_down(stretched_strip, 0,
                {"material.rubber.membrane=\"springs\"",
                 "material.rubber.structural_stiffness=2000", "material.rubber.shear_stiffness=0"});
  EXPECT_NEAR(decay.loss_factor, loss_factor * decay.frequency / 50, 0.02 * loss_factor);
}

// Cloth whose stiffness differs by direction, or comes from a table, takes the same times.
TEST(LossFactor, DampsWovenMembranesAsMeasured) {
  std::string bare = stretched_strip;
  const std::string stiffness = "membrane_stiffness = 2000\n";
  bare.erase(bare.find(stiffness), stiffness.size());
  const std::string woven =
      "[material.rubber.orthotropic_membrane]\nweft_stiffness = 500\nshear_modulus = 200\n";
  for (const std::string& warp :
       {std::string("warp_stiffness = 2000\n"),
        std::string("warp_curve = { strains = [-0.5, 0, 0.5], tensions = [-1000, 0, 1000] }\n")}) {
    SCOPED_TRACE(warp);
    const bench::Decay decay = ring_down(bare + woven + warp, 0);
    EXPECT_NEAR(decay.frequency, 50, 0.01 * 50);
    EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
  }
}
TEST(LossFactor, DampsWovenBendingAsMeasured) {
  std::string text = bent_strip;
  const std::string stiffness = "bending_stiffness = 0.01\n";
  text.erase(text.find(stiffness), stiffness.size());
  text += "[material.cloth.orthotropic_bending]\n";
  for (const char* stiffnesses :
       {"warp = [0.01]\nbias = [0.005]\nweft = [0.003]\n",
        "warp = [0.01, 0.01]\nbias = [0.005, 0.005]\nweft = [0.003, 0.003]\n"
        "curvatures = [0, 1]\n"}) {
    SCOPED_TRACE(stiffnesses);
    const bench::Decay decay = ring_down(text + stiffnesses, 2);
    EXPECT_NEAR(decay.frequency, 12.514, 0.01 * 12.514);
    EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
  }
}

// Beside its frequency the loss factor is proportional to the frequency, as the guide says.
TEST(LossFactor, FollowsTheFrequency) {
  for (const double factor : {0.5, 2.0}) {
    const bench::Decay decay = ring_down(
        bent_strip, 2, {"material.cloth.loss_frequency=" + std::to_string(12.514 * factor)});
    EXPECT_NEAR(decay.loss_factor, loss_factor / factor, 0.02 * loss_factor / factor);
  }
}

// It is another way to write the damping times.
TEST(LossFactor, EqualsTheTimesOfTheTheory) {
  std::string times = bent_strip;
  const std::string keys = "loss_factor = 0.06\nloss_frequency = 12.514\n";
  const std::string time = number_text(0.06 / (2 * pi * 12.514));
  times.replace(times.find(keys), keys.size(),
                "stiffness_damping = " + time + "\nbending_damping = " + time + "\n");
  Simulation one = simulation_of(bent_strip), other = simulation_of(times);
  for (int i = 0; i < 20; ++i) {
    ASSERT_FALSE(one.step());
    ASSERT_FALSE(other.step());
  }
  EXPECT_LT(position_difference({one.state().begin(), one.state().end()},
                                {other.state().begin(), other.state().end()}),
            1e-12);
}

// A shell that vibrates along itself has the damping of its membrane.
TEST(LossFactor, DampsTheMembraneOfShellsAsMeasured) {
  std::string text = stretched_strip;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("density = 0.2\nmembrane_stiffness = 2000\n",
          "model = \"shell\"\nyoungs_modulus = 2e6\nshell_thickness = 1e-3\n"
          "volume_density = 200\n");
  replace("resolution = [2, 26]", "resolution = [4, 13]");
  const bench::Decay decay = ring_down(text, 0);
  EXPECT_NEAR(decay.frequency, 50, 0.01 * 50);
  EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
}

TEST(LossFactor, DampsShells) {
  const std::string shell = R"(
[time]
method = "euler"
step = 1e-3
duration = 0.01
[contact]
enabled = false
[material.cloth]
model = "shell"
youngs_modulus = 2e11
shell_thickness = 1e-3
volume_density = 7800
loss_factor = 0.1
loss_frequency = 100
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
)";
  const auto scene = build_scene(parse_case(shell, "test.toml"));
  Statistics statistics;
  EXPECT_TRUE(Dynamics(*scene, statistics).has_damping());
  EXPECT_NEAR(scene->bodies[0].material->membrane_damping_time().constant(), 0.1 / (200 * pi),
              1e-15);
}

}  // namespace weft::sim::loss_factor_test
