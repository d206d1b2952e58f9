#include "materials/drag.h"

#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::Drag;
using materials::Nodes3;

class DragForce final : public Force {
 public:
  DragForce(std::vector<std::array<int, 3>> triangles, std::vector<Drag> drags, const Vec3& wind,
            int particle_count)
      : triangles_(std::move(triangles), particle_count), drags_(std::move(drags)), wind_(wind) {}

  std::string_view name() const override { return "drag"; }
  // Drag stores nothing.
  double energy(const Kinematics&, int) override { return 0; }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    triangles_.for_each(threads, [&](int i) {
      const Vec3 third = materials::drag_force(drags_[i], gather(i, state.position),
                                               gather(i, state.velocity), wind_) /
                         3;
      for (int particle : triangles_[i]) force[particle] += third;
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    triangles_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { triangles_.attach(pattern); }

  void add_derivatives(const Kinematics& state, BlockMatrix&, BlockMatrix& damping, Definiteness,
                       int threads) override {
    triangles_.for_each(threads, [&](int i) {
      const Mat3 ninth = materials::drag_damping(drags_[i], gather(i, state.position),
                                                 gather(i, state.velocity), wind_) /
                         9;
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) triangles_.add_block(i, a, b, ninth, damping);
      }
    });
  }

 private:
  Nodes3 gather(int i, std::span<const Vec3> values) const {
    Nodes3 nodes;
    for (int node = 0; node < 3; ++node) nodes.col(node) = values[triangles_[i][node]];
    return nodes;
  }

  StencilArray<3> triangles_;
  std::vector<Drag> drags_;
  Vec3 wind_;
};

}  // namespace

std::unique_ptr<Force> make_drag_force(const Scene& scene) {
  std::vector<std::array<int, 3>> triangles;
  std::vector<Drag> drags;
  const double density = scene.source.world.air_density;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const Drag drag{density * body.material->normal_drag, density * body.material->tangential_drag};
    if (drag.normal == 0 && drag.tangential == 0) continue;
    for (const std::array<int, 3>& t : body.mesh.triangles) {
      triangles.push_back(
          {t[0] + body.first_particle, t[1] + body.first_particle, t[2] + body.first_particle});
      drags.push_back(drag);
    }
  }
  if (triangles.empty()) return nullptr;
  return std::make_unique<DragForce>(std::move(triangles), std::move(drags),
                                     scene.source.world.wind, scene.dynamic_particles);
}

}  // namespace weft::sim
