#include <algorithm>

#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/relaxation.h"

namespace weft::sim {

namespace {

// Finds equilibria by relaxation. The load at time t is t / duration of the case's gravity and
// applied loads.
class StaticIntegrator final : public OneStepIntegrator {
 public:
  StaticIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics),
        relaxation_(scene, dynamics),
        path_(dynamics),
        acceleration_(scene.source.world.gravity.constant().norm()) {
    if (dynamics.has_loads())
      acceleration_ = applied_acceleration(dynamics, 0, dynamics.initial_state());
    set_load(0);
  }

  int last_order() const override { return 0; }
  void transfer(StateArchive& archive) override {
    transfer_steps(archive);
    relaxation_.transfer(archive);
    if (archive.reads()) set_load(time());
  }
  IntegratorCounts counts() const override {
    IntegratorCounts counts = OneStepIntegrator::counts();
    counts.newton_iterations = relaxation_.newton_iterations();
    counts.linear_iterations = relaxation_.linear_iterations();
    counts.linear_setups = relaxation_.newton_iterations();
    return counts;
  }

 private:
  bool checks_its_own_path() const override { return true; }

  // Sets the loads of a time (s).
  void set_load(double time) {
    dynamics().set_load(time / scene().source.time.duration);
    dynamics().set_load_factor(time / scene().source.time.duration);
  }

  Trouble attempt(double& end, std::span<double> y) override {
    set_load(end);
    const auto half = static_cast<std::ptrdiff_t>(y.size() / 2);
    std::copy(state().begin(), state().begin() + half, y.begin());
    std::fill(y.begin() + half, y.end(), 0.0);
    path_.start(time(), positions());
    const Relaxation::End found =
        relaxation_.relax({end, acceleration_, false, [this] { return should_stop(); }}, y, path_);
    if (found == Relaxation::End::at_rest) return Trouble::none;
    if (found == Relaxation::End::blocked) {
      set_fault(relaxation_.fault());
      return trouble_of_fault();
    }
    end = time();
    set_fault({});
    set_place(relaxation_.worst_particle());
    return Trouble::not_converged;
  }

  Relaxation relaxation_;
  SafePath path_;
  double acceleration_ = 0;  // applied acceleration under the full loads (m/s^2)
};

}  // namespace

std::unique_ptr<Integrator> make_static_integrator(const Scene& scene, Dynamics& dynamics) {
  switch (scene.source.equilibria.loading) {
    case Loading::in_time:
      return make_quasi_static_integrator(scene, dynamics);
    case Loading::arc_length:
      return make_arc_length_integrator(scene, dynamics);
    case Loading::proportional:
      break;
  }
  return std::make_unique<StaticIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
