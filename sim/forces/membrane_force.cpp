#include "materials/membrane.h"

#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/parallel.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::Nodes3;
using materials::TriangleMembrane;

Nodes3 gather(const std::array<int, 3>& triangle, std::span<const Vec3> values) {
  Nodes3 nodes;
  for (int i = 0; i < 3; ++i) nodes.col(i) = values[triangle[i]];
  return nodes;
}

class MembraneForce final : public Force {
 public:
  MembraneForce(std::vector<std::array<int, 3>> triangles, std::vector<TriangleMembrane> membranes,
                int particle_count)
      : triangles_(std::move(triangles), particle_count), membranes_(std::move(membranes)) {}

  std::string_view name() const override { return "membrane"; }

  double energy(const Kinematics& state, int threads) override {
    return parallel_sum(triangles_.count(), threads, [&](int first, int last) {
      double sum = 0;
      for (int i = first; i < last; ++i) {
        sum += materials::membrane_energy(membranes_[i], gather(triangles_[i], state.position));
      }
      return sum;
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    triangles_.for_each(threads, [&](int i) {
      const Nodes3 f =
          materials::membrane_forces(membranes_[i], gather(triangles_[i], state.position),
                                     gather(triangles_[i], state.velocity));
      for (int node = 0; node < 3; ++node) force[triangles_[i][node]] += f.col(node);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    triangles_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { triangles_.attach(pattern); }

  void add_derivatives(const Kinematics& state, BlockMatrix& stiffness, BlockMatrix& damping,
                       Definiteness definiteness, int threads) override {
    const bool pull_only = definiteness == Definiteness::semi_definite;
    triangles_.for_each(threads, [&](int i) {
      const Nodes3 x = gather(triangles_[i], state.position);
      const Nodes3 v = gather(triangles_[i], state.velocity);
      triangles_.add_block_matrix(i, materials::membrane_stiffness(membranes_[i], x, v, pull_only),
                                  stiffness);
      if (membranes_[i].damping_time > 0) {
        triangles_.add_block_matrix(i, materials::membrane_damping(membranes_[i], x), damping);
      }
    });
  }

 private:
  StencilArray<3> triangles_;
  std::vector<TriangleMembrane> membranes_;
};

}  // namespace

std::unique_ptr<Force> make_membrane_force(const Scene& scene) {
  std::vector<std::array<int, 3>> triangles;
  std::vector<TriangleMembrane> membranes;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const MaterialCase& material = *body.material;
    if (material.membrane != MembraneModel::triangles || material.membrane_stiffness == 0) continue;
    for (const std::array<int, 3>& t : body.mesh.triangles) {
      membranes.push_back(
          materials::make_triangle_membrane(gather(t, body.rest), material.membrane_stiffness,
                                            material.poisson_ratio, material.stiffness_damping));
      triangles.push_back(
          {t[0] + body.first_particle, t[1] + body.first_particle, t[2] + body.first_particle});
    }
  }
  if (triangles.empty()) return nullptr;
  return std::make_unique<MembraneForce>(std::move(triangles), std::move(membranes),
                                         scene.dynamic_particles);
}

}  // namespace weft::sim
