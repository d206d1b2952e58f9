#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/solver/multigrid.h"
#include "sim/solver/velocity_system.h"

namespace weft::sim::shell_multigrid_test {
namespace {

constexpr double longest_gamma = 1e-3;  // s, a hundredth of the plate's period

// A steel plate of n x n control points, clamped at one edge and bent, as in
// cases/vibrating_plate.toml, with the semi-definite matrix that integrators use.
class BentPlate {
 public:
  explicit BentPlate(int n, const std::string& preconditioner = "automatic")
      : scene_(build_scene(parse_case(text_of(n, preconditioner), "test.toml"))),
        dynamics_(*scene_, statistics_),
        system_(dynamics_) {
    const std::vector<double> state = dynamics_.initial_state();
    rate_.resize(state.size());
    EXPECT_FALSE(dynamics_.rate(0, state, rate_));
    dynamics_.assemble(0, state, Definiteness::semi_definite);
  }

  Dynamics& dynamics() { return dynamics_; }
  const Scene& scene() const { return *scene_; }

  // Solves for the first Newton correction of a step to a relative error in the norm of A.
  VelocitySystem::Outcome solve(double gamma, double error) {
    std::vector<double> b(rate_.size(), 0.0);
    for (std::size_t i = b.size() / 2; i < b.size(); ++i) b[i] = gamma * rate_[i];
    const std::vector<double> weight(b.size(), 1.0);
    correction_.assign(b.size(), 0.0);
    return system_.solve(gamma, b, weight,
                         {.error = error, .scale = VelocitySystem::Goal::Scale::matrix},
                         correction_);
  }
  // Returns the velocities of the last correction.
  std::vector<double> velocities() const {
    return {correction_.begin() + static_cast<std::ptrdiff_t>(correction_.size() / 2),
            correction_.end()};
  }

 private:
  static std::string text_of(int n, const std::string& preconditioner) {
    const std::string size = std::to_string(n);
    return "[time]\npreconditioner = \"" + preconditioner +
           "\"\n[world]\ngravity = [0, 0, 0]\n[contact]\nenabled = false\n[compute]\nthreads = 1\n"
           "[material.steel]\nmodel = \"shell\"\nyoungs_modulus = 2e11\npoisson_ratio = 0.3\n"
           "shell_thickness = 5e-4\nvolume_density = 7850\n[[body]]\nname = \"plate\"\n"
           "shape = { type = \"rectangle\", size = [0.2, 0.1], resolution = [" +
           size + ", " + size +
           "] }\nstart = { bend_radius = 0.5 }\n[[body.pin]]\nedges = [\"first_col\"]\n"
           "clamp = true\n";
  }

  std::unique_ptr<const Scene> scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  VelocitySystem system_;
  std::vector<double> rate_, correction_;
};

TEST(ShellMultigrid, IterationsDependOnNeitherSizeNorStep) {
  for (const double gamma : {1e-4, longest_gamma}) {
    std::vector<int> iterations;
    for (const int n : {17, 33, 65, 129}) {
      const VelocitySystem::Outcome outcome = BentPlate(n).solve(gamma, 1e-4);
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
