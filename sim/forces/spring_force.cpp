#include <set>

#include "sim/base/parallel.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/springs.h"
#include "sim/forces/stencil_array.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::Spring;

class SpringForce final : public Force {
 public:
  SpringForce(SpringNetwork network, int particle_count)
      : ends_(network.ends, particle_count),
        springs_(std::move(network.springs)),
        damping_times_(std::move(network.damping_times)),
        is_damped_(network.is_damped) {}

  std::string_view name() const override { return "springs"; }
  bool has_damping() const override { return is_damped_; }
  bool varies() const override { return damping_times_.varies(); }
  void set_time(const Instant& now) override {
    damping_times_.visit_changed(now, [&](int first, int last, double time) {
      for (int i = first; i < last; ++i) springs_[i].damping_time = time;
    });
  }
  double evaluation_work() const override { return 1.0; }
  bool is_membrane() const override { return true; }

  double energy(const Kinematics& state, int threads) override {
    return parallel_sum(ends_.count(), threads, [&](int first, int last) {
      double sum = 0;
      for (int i = first; i < last; ++i) {
        sum += materials::spring_energy(springs_[i], state.position[ends_[i][0]],
                                        state.position[ends_[i][1]]);
      }
      return sum;
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    ends_.for_each(threads, [&](int i) {
      const auto [a, b] = ends_[i];
      const Vec3 f = materials::spring_force(springs_[i], state.position[a], state.position[b],
                                             state.velocity[a], state.velocity[b]);
      force[a] += f;
      force[b] -= f;
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    ends_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { ends_.attach(pattern); }

  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    const bool pull_only = definiteness == Definiteness::semi_definite;
    ends_.for_each(threads, [&](int i) {
      const auto [a, b] = ends_[i];
      Mat3 stiffness =
          materials::spring_stiffness(springs_[i], state.position[a], state.position[b],
                                      state.velocity[a], state.velocity[b], pull_only);
      if (springs_[i].damping_time > 0) {
        const Mat3 damping =
            materials::spring_damping(springs_[i], state.position[a], state.position[b]);
        if (into.is_joined()) {
          const Vec3 pull = damping * (into.along[a] - into.along[b]);
          into.product[a] += pull;
          into.product[b] -= pull;
          stiffness += into.inverse_gamma * damping;
        } else {
          ends_.add_pair(i, damping, *into.damping);
        }
      }
      ends_.add_pair(i, stiffness, into.stiffness);
    });
  }

 private:
  StencilArray<2> ends_;
  std::vector<Spring> springs_;
  VaryingNumbers damping_times_;
  bool is_damped_;  // true if damped at any time
};

// Collects springs between texels at a given offset in the image. Two particles get at most one
// spring, even if both lie in two patches.
class SpringCollector {
 public:
  SpringCollector(const SceneBody& body, double damping_time, SpringNetwork& network)
      : body_(body), damping_time_(damping_time), network_(network) {}

  void add(int row_step, int col_step, double stiffness) {
    if (stiffness == 0) return;
    for (std::size_t p = 0; p < body_.atlas.patches().size(); ++p) {
      const bsi::Patch& patch = body_.atlas.patches()[p];
      for (int r = 0; r < patch.rows; ++r) {
        for (int c = 0; c < patch.cols; ++c) {
          add_one(static_cast<int>(p), r, c, r + row_step, c + col_step, stiffness);
        }
      }
    }
  }

 private:
  void add_one(int p, int row, int col, int other_row, int other_col, double stiffness) {
    const bsi::Patch& patch = body_.atlas.patches()[p];
    const auto wrap = [](int i, int count, bool wraps) { return wraps ? (i + count) % count : i; };
    other_row = wrap(other_row, patch.rows, patch.wrap_v);
    other_col = wrap(other_col, patch.cols, patch.wrap_u);
    if (other_row < 0 || other_row >= patch.rows || other_col < 0 || other_col >= patch.cols)
      return;
    const int a = body_.atlas.particle(p, row, col),
              b = body_.atlas.particle(p, other_row, other_col);
    if (a == b || !seen_.insert({std::min(a, b), std::max(a, b)}).second) return;
    network_.ends.push_back({a + body_.first_particle, b + body_.first_particle});
    network_.springs.push_back({(body_.rest[b] - body_.rest[a]).norm(), stiffness, damping_time_});
  }

  const SceneBody& body_;
  double damping_time_;
  SpringNetwork& network_;
  std::set<std::pair<int, int>> seen_;
};

}  // namespace

SpringNetwork springs_of(const Scene& scene) {
  SpringNetwork network;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const MaterialCase& material = *body.material;
    if (material.is_shell() || material.membrane != MembraneModel::springs) continue;
    // A square lattice with both diagonals is isotropic if k_d = k_s / 2, and then E h = 4 k_s / 3.
    const double structural =
        material.structural_stiffness.value_or(0.75 * material.membrane_stiffness);
    const double shear = material.shear_stiffness.value_or(0.5 * structural);
    const double bend = material.bend_stiffness.value_or(0.0);
    const auto first = static_cast<int>(network.springs.size());
    SpringCollector collector(body, material.membrane_damping_time().constant_or_zero(), network);
    collector.add(0, 1, structural);
    collector.add(1, 0, structural);
    collector.add(1, 1, shear);
    collector.add(1, -1, shear);
    collector.add(0, 2, bend);
    collector.add(2, 0, bend);
    network.damping_times.append(static_cast<int>(network.springs.size()) - first,
                                 material.membrane_damping_time());
    network.is_damped |= !material.membrane_damping_time().is_zero();
  }
  return network;
}

std::unique_ptr<Force> make_spring_force(const Scene& scene) {
  SpringNetwork network = springs_of(scene);
  if (network.ends.empty()) return nullptr;
  return std::make_unique<SpringForce>(std::move(network), scene.dynamic_particles);
}

}  // namespace weft::sim
