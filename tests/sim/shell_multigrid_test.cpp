#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/solver/velocity_system.h"

namespace weft::sim::shell_multigrid_test {
namespace {

// The text of a case with a steel plate of n x n control points, clamped at one edge and bent, as
// in cases/vibrating_plate.toml.
std::string bent_plate(int n) {
  const std::string size = std::to_string(n);
  return "[world]\ngravity = [0, 0, 0]\n[contact]\nenabled = false\n[compute]\nthreads = 1\n"
         "[material.steel]\nmodel = \"shell\"\nyoungs_modulus = 2e11\npoisson_ratio = 0.3\n"
         "shell_thickness = 5e-4\nvolume_density = 7850\n[[body]]\nname = \"plate\"\n"
         "shape = { type = \"rectangle\", size = [0.2, 0.1], resolution = [" +
         size + ", " + size +
         "] }\nstart = { bend_radius = 0.5 }\n[[body.pin]]\nedges = [\"first_col\"]\n"
         "clamp = true\n";
}

// Solves for the first Newton correction of a step from the start to four digits, with the
// semi-definite matrix that integrators use.
VelocitySystem::Outcome solve(const Scene& scene, double gamma) {
  Statistics statistics;
  Dynamics dynamics(scene, statistics);
  const std::vector<double> state = dynamics.initial_state();
  std::vector<double> rate(state.size()), b(state.size(), 0.0), correction(state.size());
  EXPECT_FALSE(dynamics.rate(0, state, rate));
  dynamics.assemble(0, state, Definiteness::semi_definite);
  for (std::size_t i = b.size() / 2; i < b.size(); ++i) b[i] = gamma * rate[i];
  const std::vector<double> weight(b.size(), 1.0);
  VelocitySystem system(dynamics);
  return system.solve(gamma, b, weight,
                      {.error = 1e-4, .scale = VelocitySystem::Goal::Scale::matrix}, correction);
}

// Steps of a thousandth and of a hundredth of the plate's period.
TEST(ShellMultigrid, IterationsDependOnNeitherSizeNorStep) {
  for (const double gamma : {1e-4, 1e-3}) {
    std::vector<int> iterations;
    for (const int n : {17, 33, 65, 129}) {
      const auto scene = build_scene(parse_case(bent_plate(n), "test.toml"));
      const VelocitySystem::Outcome outcome = solve(*scene, gamma);
      EXPECT_TRUE(outcome.converged && outcome.multigrid) << n << ", " << gamma;
      EXPECT_LE(outcome.iterations, 20) << n << ", " << gamma;
      iterations.push_back(outcome.iterations);
    }
    const auto [fewest, most] = std::minmax_element(iterations.begin(), iterations.end());
    EXPECT_LE(*most, 1.5 * *fewest) << gamma;
  }
}

}  // namespace
}  // namespace weft::sim::shell_multigrid_test
