// Damping by a measured loss factor, against the decay of free vibrations.
#include <cmath>
#include <numbers>

#include "sim/case/case_text.h"
#include "tests/sim/bad_case.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::loss_factor_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double loss_factor = 0.06;

// A narrow strip, clamped at one end and bent at the start; Poisson's ratio of 0 makes it a beam.
// Its lowest frequency is 1.8751^2 / (2 pi) sqrt(D / (density L^4)) = 12.514 Hz.
constexpr const char* bent_strip = R"(
[time]
method = "implicit_midpoint"
step = 8e-4
duration = 0.7
frames_per_second = 1250
position_tolerance = 1e-8
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.steel]
density = 0.2
membrane_stiffness = 2e4
poisson_ratio = 0
bending_stiffness = 0.01
loss_factor = 0.06
loss_frequency = 12.514
[[body]]
name = "strip"
start = { bend_radius = 5 }
shape = { type = "rectangle", size = [0.1, 0.01], resolution = [2, 17] }
[[body.pin]]
edges = ["first_col"]
clamp = true
)";

// A strip that is stretched at the start and held at one end vibrates along itself, at
// sqrt(E h / density) / (4 L) = 50 Hz.
constexpr const char* stretched_strip = R"(
[time]
method = "implicit_midpoint"
step = 2e-4
duration = 0.18
frames_per_second = 5000
position_tolerance = 1e-9
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.rubber]
density = 0.2
membrane_stiffness = 2000
poisson_ratio = 0
loss_factor = 0.06
loss_frequency = 50
[[body]]
name = "strip"
stretch = [1.0004, 1, 1]
shape = { type = "rectangle", size = [0.5, 0.02], resolution = [2, 26] }
[[body.pin]]
edges = ["first_col"]
)";

struct Decay {
  double frequency = 0;  // Hz
  double loss_factor = 0;
};

// Frequency and loss factor of a decaying vibration, sampled every `step` s, from the ways between
// its extremes: those hold whatever the place about which it vibrates. The logarithmic decrement of
// x'' + eta omega x' + omega^2 x = 0 is delta = pi eta / sqrt(1 - eta^2 / 4). The first two
// periods, in which higher vibrations die out, do not count.
Decay decay_of(const std::vector<double>& samples, double step) {
  std::vector<double> times, extremes;
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    const double before = samples[i - 1], here = samples[i], after = samples[i + 1];
    if ((here > before) != (here >= after)) continue;
    const double bend = before - 2 * here + after, shift = 0.5 * (before - after) / bend;
    times.push_back(step * (static_cast<double>(i) + shift));
    extremes.push_back(here - 0.25 * (before - after) * shift);
  }
  const std::size_t skipped = 4;
  if (times.size() < skipped + 8) {
    ADD_FAILURE() << "it does not vibrate";
    return {};
  }
  const auto way = [&](std::size_t i) { return std::abs(extremes[i + 1] - extremes[i]); };
  const std::size_t last = times.size() - 2;
  const double periods = 0.5 * static_cast<double>(last - skipped);
  const double delta = std::log(way(skipped) / way(last)) / periods;
  const double ratio = delta / pi;
  return {periods / (times[last] - times[skipped]), ratio / std::sqrt(1 + ratio * ratio / 4)};
}

// The displacement of the end of the strip along an axis from its place at rest.
Decay ring_down(const std::string& text, int axis, double rest, const Overrides& overrides = {}) {
  Simulation simulation = simulation_of(text, overrides);
  const double step = simulation.scene().source.time.step.value_or(0);
  std::vector<double> samples{simulation.position("strip").back()[axis] - rest};
  while (simulation.time() < simulation.scene().source.time.duration - 0.5 * step) {
    if (const auto failure = simulation.step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    samples.push_back(simulation.position("strip").back()[axis] - rest);
  }
  return decay_of(samples, step);
}

}  // namespace

TEST(LossFactor, DampsBendingAsMeasured) {
  const Decay decay = ring_down(bent_strip, 2, 0);
  EXPECT_NEAR(decay.frequency, 12.514, 0.01 * 12.514);
  EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
}

TEST(LossFactor, DampsTheMembraneAsMeasured) {
  const Decay decay = ring_down(stretched_strip, 0, 0.25);
  EXPECT_NEAR(decay.frequency, 50, 0.01 * 50);
  EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
}

TEST(LossFactor, DampsSpringsAsMeasured) {
  const Decay decay =
      ring_down(stretched_strip, 0, 0.25,
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
    const Decay decay = ring_down(bare + woven + warp, 0, 0.25);
    EXPECT_NEAR(decay.frequency, 50, 0.01 * 50);
    EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
  }
}
TEST(LossFactor, DampsWovenBendingAsMeasured) {
  std::string text = bent_strip;
  const std::string stiffness = "bending_stiffness = 0.01\n";
  text.erase(text.find(stiffness), stiffness.size());
  text += "[material.steel.orthotropic_bending]\n";
  for (const char* stiffnesses :
       {"warp = [0.01]\nbias = [0.005]\nweft = [0.003]\n",
        "warp = [0.01, 0.01]\nbias = [0.005, 0.005]\nweft = [0.003, 0.003]\n"
        "curvatures = [0, 1]\n"}) {
    SCOPED_TRACE(stiffnesses);
    const Decay decay = ring_down(text + stiffnesses, 2, 0);
    EXPECT_NEAR(decay.frequency, 12.514, 0.01 * 12.514);
    EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
  }
}

// Beside its frequency the loss factor is proportional to the frequency, as the guide says.
TEST(LossFactor, FollowsTheFrequency) {
  for (const double factor : {0.5, 2.0}) {
    const Decay decay = ring_down(
        bent_strip, 2, 0, {"material.steel.loss_frequency=" + std::to_string(12.514 * factor)});
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

// The strip of the first test as a shell: D = E h^3 / 12, the same density per area.
TEST(LossFactor, DampsShellsAsMeasured) {
  std::string text = bent_strip;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("density = 0.2\nmembrane_stiffness = 2e4\n",
          "model = \"shell\"\nyoungs_modulus = 1.2e8\nshell_thickness = 1e-3\n"
          "volume_density = 200\n");
  replace("bending_stiffness = 0.01\n", "");
  replace("resolution = [2, 17]", "resolution = [4, 11]");
  const Decay decay = ring_down(text, 2, 0);
  EXPECT_NEAR(decay.frequency, 12.514, 0.01 * 12.514);
  EXPECT_NEAR(decay.loss_factor, loss_factor, 0.02 * loss_factor);
}

// Along itself, the strain of its membrane counts.
TEST(LossFactor, DampsTheMembraneOfShellsAsMeasured) {
  std::string text = stretched_strip;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("density = 0.2\nmembrane_stiffness = 2000\n",
          "model = \"shell\"\nyoungs_modulus = 2e6\nshell_thickness = 1e-3\n"
          "volume_density = 200\n");
  replace("resolution = [2, 26]", "resolution = [4, 13]");
  const Decay decay = ring_down(text, 0, 0.25);
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
[material.steel]
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
  const auto scene = build_scene(parse_case(shell, "test.toml", {}));
  Statistics statistics;
  EXPECT_TRUE(Dynamics(*scene, statistics).has_damping());
  EXPECT_NEAR(scene->bodies[0].material->membrane_damping_time().constant(), 0.1 / (200 * pi),
              1e-15);
}

}  // namespace weft::sim::loss_factor_test
