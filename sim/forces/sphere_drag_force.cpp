// Resistance of air against the spheres of [[particles]].
#include <numbers>

#include "sim/forces/force_arrays.h"
#include "sim/scene/scene.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

namespace {

class SphereDragForce final : public Force {
 public:
  explicit SphereDragForce(const Scene& scene)
      : wind_in_time_(scene.source.world.wind), density_in_time_(scene.source.world.air_density) {
    for (int b = 0; b < scene.dynamic_bodies; ++b) {
      const SceneBody& body = scene.bodies[b];
      if (body.spheres == nullptr || body.are_spins) continue;
      if (body.spheres->drag_coefficient == 0) continue;
      const double radius = body.spheres->radius;
      const double area = std::numbers::pi * radius * radius;
      for (int i = 0; i < body.particle_count(); ++i)
        spheres_.push_back({body.first_particle + i, 0.5 * body.spheres->drag_coefficient * area});
    }
    set_time({});
  }

  bool is_empty() const { return spheres_.empty(); }
  std::string_view name() const override { return "particle_drag"; }
  bool has_damping() const override { return true; }
  bool is_external() const override { return true; }
  bool varies() const override { return wind_in_time_.varies() || density_in_time_.varies(); }
  void set_time(const Instant& now) override {
    wind_ = wind_in_time_.at(now);
    density_ = density_in_time_.at(now);
  }
  double evaluation_work() const override { return 0.3; }
  // Drag stores no energy.
  double energy(const Kinematics&, int) override { return 0; }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int /*threads*/) override {
    for (const auto& [particle, factor] : spheres_) {
      const Vec3 flow = wind_ - state.velocity[particle];
      force[particle] += density_ * factor * flow.norm() * flow;
    }
  }
  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    for (const auto& [particle, factor] : spheres_) neighbours[particle].push_back(particle);
  }
  void attach(const BlockPattern& /*pattern*/) override {}

  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness,
                       int /*threads*/) override {
    BlockMatrix& matrix = into.is_joined() ? into.stiffness : *into.damping;
    const double scale = into.is_joined() ? into.inverse_gamma : 1;
    for (const auto& [particle, factor] : spheres_) {
      const Vec3 flow = wind_ - state.velocity[particle];
      const double speed = flow.norm();
      if (speed == 0) continue;
      const Mat3 damping =
          density_ * factor * (speed * Mat3::Identity() + flow * flow.transpose() / speed);
      matrix.upper_block(matrix.pattern().upper_diagonal(particle)) += scale * damping;
      if (into.is_joined()) into.product[particle] += damping * into.along[particle];
    }
  }

 private:
  struct Sphere {
    int particle = 0;
    double factor = 0;  // m^2, half of the drag coefficient times the area of the cross-section
  };

  TimeCurve<Vec3> wind_in_time_;
  TimeCurve<double> density_in_time_;
  std::vector<Sphere> spheres_;
  Vec3 wind_{0, 0, 0};  // m/s
  double density_ = 0;  // kg/m^3
};

}  // namespace

std::unique_ptr<Force> make_sphere_drag_force(const Scene& scene) {
  // The method of impulses computes drag itself.
  if (scene.source.time.method == TimeMethod::impulses) return nullptr;
  auto force = std::make_unique<SphereDragForce>(scene);
  if (force->is_empty()) return nullptr;
  return force;
}

}  // namespace weft::sim
