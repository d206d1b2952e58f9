// Stiff springs that hold particles in some directions (sim/scene/sliding_supports.h).
#include <algorithm>

#include "sim/case/membrane_stiffness.h"
#include "sim/case/time_methods.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/scene/scene.h"
#include "sim/scene/sliding_supports.h"

namespace weft::sim {

namespace {

// Ratio of the stiffness of a spring to the in-plane stiffness of the body (both in N/m), for
// equilibria and for motion. The error of a held component is about the local stretch of the body
// divided by this ratio. Rounding of positions limits the ratio for equilibria. The tolerance of
// positions limits it for motion.
constexpr double static_hardness = 1e5, hardness = 1e3;
// Ratio of a spring's damping to its stiffness in motion, s.
constexpr double damping_time_in_motion = 1e-4;

double own_stiffness(const MaterialCase& material) {
  if (material.is_shell()) return material.youngs_modulus * material.shell_thickness;
  return largest_membrane_stiffness(material);
}

class SupportForce final : public Force {
 public:
  explicit SupportForce(const Scene& scene)
      : is_static_(traits_of(scene.source.time.method).finds_equilibria()) {
    for (int b = 0; b < scene.dynamic_bodies; ++b) {
      const SceneBody& body = scene.bodies[b];
      if (body.supports) add(b, body);
    }
    set_time({});
  }

  bool is_empty() const { return springs_.empty(); }
  std::string_view name() const override { return "support"; }
  bool has_damping() const override { return damping_time() > 0; }
  bool is_constraint() const override { return true; }
  bool is_support() const override { return true; }
  bool varies() const override { return has_moving_points(); }
  bool has_moving_points() const override {
    return std::ranges::any_of(springs_, [](const Spring& each) { return each.motion != nullptr; });
  }
  void set_time(const Instant& now) override {
    for (Spring& each : springs_) {
      Vec3 place = each.source->start, rate = Vec3::Zero();
      Vec3 base = each.source->start_base, base_rate = Vec3::Zero();
      if (each.motion != nullptr) {
        const RigidPose pose = each.motion->pose(now.time, now.within < now.time);
        pose.place(each.source->start, place, rate);
        if (each.base >= 0) pose.place(each.source->start_base, base, base_rate);
      }
      each.target = each.source->direction.dot(place - base);
      each.target_rate = each.source->direction.dot(rate - base_rate);
      each.place = place;
    }
  }
  double evaluation_work() const override { return 0.3; }

  double energy(const Kinematics& state, int /*threads*/) override {
    double sum = 0;
    for (const Spring& each : springs_) {
      const double gap = gap_of(each, state.position);
      sum += 0.5 * each.stiffness * gap * gap;
    }
    return sum;
  }
  double power_of_moving_points(const Kinematics& state) override {
    double power = 0;
    for (const Spring& each : springs_) power += force_of(each, state) * each.target_rate;
    return power;
  }
  void list_outer_forces(const Kinematics& state, std::vector<OuterForce>& all) override {
    for (const Spring& each : springs_) {
      const Vec3 force = force_of(each, state) * each.source->direction;
      const auto list = [&](int particle, const Vec3& part) {
        OuterForce& outer = all.emplace_back();
        outer.body = each.body;
        outer.pin = each.source->pin;
        outer.place = state.position[particle];
        outer.force = part;
      };
      list(each.particle, force);
      if (each.base >= 0) list(each.base, -force);
    }
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int /*threads*/) override {
    for (const Spring& each : springs_) {
      const Vec3 pull = force_of(each, state) * each.source->direction;
      force[each.particle] += pull;
      if (each.base >= 0) force[each.base] -= pull;
    }
  }
  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    for (const Spring& each : springs_) {
      neighbours[each.particle].push_back(each.particle);
      if (each.base < 0) continue;
      neighbours[each.particle].push_back(each.base);
      neighbours[each.base].push_back(each.particle);
    }
  }
  void attach(const BlockPattern& pattern) override {
    for (Spring& each : springs_) {
      if (each.base < 0) continue;
      const int row = std::min(each.particle, each.base);
      each.between = pattern.upper(row, pattern.slot(row, std::max(each.particle, each.base)));
    }
  }
  void add_derivatives(const Kinematics& /*state*/, const Derivatives& into,
                       Definiteness /*definiteness*/, int /*threads*/) override {
    for (const Spring& each : springs_) {
      const Vec3& direction = each.source->direction;
      const Mat3 stiffness = each.stiffness * direction * direction.transpose();
      const Mat3 damping = damping_time() * stiffness;
      if (into.is_joined()) {
        add_blocks(each, stiffness + into.inverse_gamma * damping, into.stiffness);
        Vec3 along = into.along[each.particle];
        if (each.base >= 0) along -= into.along[each.base];
        into.product[each.particle] += damping * along;
        if (each.base >= 0) into.product[each.base] -= damping * along;
      } else {
        add_blocks(each, stiffness, into.stiffness);
        if (has_damping()) add_blocks(each, damping, *into.damping);
      }
    }
  }

 private:
  struct Spring {
    const SlidingSupport* source = nullptr;
    const RigidMotion* motion = nullptr;  // null if the support is at rest
    int particle = 0, base = -1;          // global indices; base -1: no base
    double stiffness = 0;                 // N/m
    int body = 0;
    int between = -1;                    // index of the upper block of particle and base
    double target = 0, target_rate = 0;  // m and m/s, at the time of set_time()
    Vec3 place{0, 0, 0};
  };

  void add(int number, const SceneBody& body) {
    const double stiffness =
        (is_static_ ? static_hardness : hardness) * own_stiffness(*body.material);
    for (const SlidingSupport& source : body.supports->all) {
      Spring spring{.source = &source,
                    .particle = body.first_particle + source.particle,
                    .stiffness = stiffness,
                    .body = number};
      if (source.base >= 0) spring.base = body.first_particle + source.base;
      if (body.supports->moves[source.pin] != 0)
        spring.motion = &body.supports->motions[source.pin];
      springs_.push_back(spring);
    }
  }
  static double gap_of(const Spring& spring, std::span<const Vec3> position) {
    Vec3 place = position[spring.particle];
    if (spring.base >= 0) place -= position[spring.base];
    return spring.source->direction.dot(place) - spring.target;
  }
  static double rate_of(const Spring& spring, std::span<const Vec3> velocity) {
    Vec3 rate = velocity[spring.particle];
    if (spring.base >= 0) rate -= velocity[spring.base];
    return spring.source->direction.dot(rate) - spring.target_rate;
  }
  double damping_time() const { return is_static_ ? 0 : damping_time_in_motion; }
  // Returns the force (N) on the particle along the spring's direction.
  double force_of(const Spring& spring, const Kinematics& state) const {
    const double damped = is_static_ ? 0 : damping_time() * rate_of(spring, state.velocity);
    return -spring.stiffness * (gap_of(spring, state.position) + damped);
  }
  static void add_blocks(const Spring& spring, const Mat3& block, BlockMatrix& matrix) {
    add_diagonal(spring.particle, block, matrix);
    if (spring.base < 0) return;
    add_diagonal(spring.base, block, matrix);
    matrix.upper_block(spring.between) -= block;
  }
  static void add_diagonal(int particle, const Mat3& block, BlockMatrix& matrix) {
    matrix.upper_block(matrix.pattern().upper_diagonal(particle)) += block;
  }

  bool is_static_;
  std::vector<Spring> springs_;
};

}  // namespace

std::unique_ptr<Force> make_support_force(const Scene& scene) {
  auto force = std::make_unique<SupportForce>(scene);
  if (force->is_empty()) return nullptr;
  return force;
}

}  // namespace weft::sim
