// Kirchhoff-Love shells: stretching and bending of spline surfaces (materials/shell.h). Joints keep
// the angles at which patches meet (materials/surface_angle.h).
#include "sim/base/parallel.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/shell_elements.h"
#include "sim/forces/shell_joints.h"

namespace weft::sim {

namespace {

class ShellForce final : public Force {
 public:
  explicit ShellForce(const Scene& scene) {
    for (int b = 0; b < scene.dynamic_bodies; ++b) {
      const SceneBody& body = scene.bodies[b];
      if (body.spline && body.spline->degree() == 2) add(body, quadratic_, quadratic_joints_);
      if (body.spline && body.spline->degree() == 3) add(body, cubic_, cubic_joints_);
    }
    visit([&](auto& parts) { parts.finish(scene.dynamic_particles); });
  }

  bool is_empty() const { return quadratic_.is_empty() && cubic_.is_empty(); }
  std::string_view name() const override { return "shell"; }
  bool has_damping() const override { return quadratic_.is_damped() || cubic_.is_damped(); }
  bool varies() const override { return quadratic_.varies() || cubic_.varies(); }
  void set_time(const Instant& now) override {
    visit([&](auto& parts) { parts.set_time(now); });
  }
  double evaluation_work() const override { return 4; }

  double energy(const Kinematics& state, int threads) override {
    double sum = 0;
    visit([&](auto& parts) {
      sum += parallel_sum(parts.count(), threads, [&](int first, int last) {
        return parts.energy(state.position, first, last);
      });
    });
    return sum;
  }
  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    visit([&](auto& parts) { parts.add_forces(state, force, threads); });
  }
  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quadratic_.add_couplings(neighbours);
    quadratic_joints_.add_couplings(neighbours);
    cubic_.add_couplings(neighbours);
    cubic_joints_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override {
    visit([&](auto& parts) { parts.attach(pattern); });
  }
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    visit([&](auto& parts) { parts.add_derivatives(state, into, definiteness, threads); });
  }

 private:
  template <class Elements, class Joints>
  static void add(const SceneBody& body, Elements& elements, Joints& joints) {
    elements.add_body(body);
    joints.add_body(body);
  }
  template <class Visit>
  void visit(const Visit& with) {
    if (!quadratic_.is_empty()) with(quadratic_);
    if (!quadratic_joints_.is_empty()) with(quadratic_joints_);
    if (!cubic_.is_empty()) with(cubic_);
    if (!cubic_joints_.is_empty()) with(cubic_joints_);
  }

  ShellElements<2> quadratic_;
  ShellElements<3> cubic_;
  ShellJoints<2> quadratic_joints_;
  ShellJoints<3> cubic_joints_;
};

}  // namespace

std::unique_ptr<Force> make_shell_force(const Scene& scene) {
  auto force = std::make_unique<ShellForce>(scene);
  if (force->is_empty()) return nullptr;
  return force;
}

}  // namespace weft::sim
