#include "materials/drag.h"

#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/stencil_numbers.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::DragOf;
using materials::Lanes;
using materials::Mat3Of;
using materials::NodesOf;
using materials::Vec3Of;

// kg/m^3, of each triangle.
struct DragNumbers {
  StencilNumbers normal, tangential;
};

class DragForce final : public Force {
 public:
  DragForce(const std::vector<std::array<int, 3>>& triangles, DragNumbers drags, const Vec3& wind,
            int particle_count)
      : triangles_(triangles, particle_count),
        drags_(std::move(drags)),
        wind_(wind.cast<Lanes>()) {}

  std::string_view name() const override { return "drag"; }
  // Drag stores nothing.
  double energy(const Kinematics&, int) override { return 0; }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    triangles_.for_each_batch(threads, [&](int first) {
      const Vec3Of<Lanes> third =
          (1.0 / 3) * materials::drag_force(batch(first), triangles_.gather(first, state.position),
                                            triangles_.gather(first, state.velocity), wind_);
      triangles_.scatter(first, NodesOf<Lanes, 3>(third.replicate<1, 3>()), force);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    triangles_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { triangles_.attach(pattern); }

  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness,
                       int threads) override {
    triangles_.for_each_batch(threads, [&](int first) {
      const Mat3Of<Lanes> block =
          (1.0 / 9) * materials::drag_damping(batch(first),
                                              triangles_.gather(first, state.position),
                                              triangles_.gather(first, state.velocity), wind_);
      if (!into.is_joined()) {
        triangles_.scatter_to_all(first, block, *into.damping);
        return;
      }
      const NodesOf<Lanes, 3> along = triangles_.gather(first, into.along);
      const Vec3Of<Lanes> product = block * (along.col(0) + along.col(1) + along.col(2));
      triangles_.scatter(first, NodesOf<Lanes, 3>(product.replicate<1, 3>()), into.product);
      triangles_.scatter_to_all(first, into.inverse_gamma * block, into.stiffness);
    });
  }

 private:
  DragOf<Lanes> batch(int first) const {
    return {drags_.normal.batch(first), drags_.tangential.batch(first)};
  }

  StencilArray<3> triangles_;
  DragNumbers drags_;
  Vec3Of<Lanes> wind_;
};

}  // namespace

std::unique_ptr<Force> make_drag_force(const Scene& scene) {
  std::vector<std::array<int, 3>> triangles;
  DragNumbers drags;
  const double density = scene.source.world.air_density;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const double normal = density * body.material->normal_drag;
    const double tangential = density * body.material->tangential_drag;
    if (normal == 0 && tangential == 0) continue;
    for (const std::array<int, 3>& t : body.mesh.triangles) {
      triangles.push_back(
          {t[0] + body.first_particle, t[1] + body.first_particle, t[2] + body.first_particle});
      drags.normal.push_back(normal);
      drags.tangential.push_back(tangential);
    }
  }
  if (triangles.empty()) return nullptr;
  return std::make_unique<DragForce>(triangles, std::move(drags), scene.source.world.wind,
                                     scene.dynamic_particles);
}

}  // namespace weft::sim
