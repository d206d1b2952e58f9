#include "materials/membrane.h"

#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/stencil_numbers.h"
#include "sim/parallel.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::lane_count;
using materials::Lanes;
using materials::Nodes3;
using materials::NodesOf;
using materials::TriangleMembrane;
using materials::TriangleMembraneOf;
using materials::Vec3Of;

// Eight triangles, but for their damping times; what is left of the last has no stiffness.
struct MembraneBatch {
  std::array<Lanes, 3> rest_squared_length{};
  Vec3Of<Lanes> root = Vec3Of<Lanes>::Zero();
  Lanes shear = 0;
};

class MembraneForce final : public Force {
 public:
  MembraneForce(const std::vector<std::array<int, 3>>& triangles,
                const std::vector<TriangleMembrane>& membranes, const std::vector<Vec3>& rest)
      : triangles_(triangles, static_cast<int>(rest.size())) {
    membranes_.resize((membranes.size() + lane_count - 1) / lane_count);
    for (std::size_t i = 0; i < membranes.size(); ++i) {
      MembraneBatch& batch = membranes_[i / lane_count];
      const std::size_t lane = i % lane_count;
      for (int k = 0; k < 3; ++k) batch.root[k].values[lane] = membranes[i].root[k];
      batch.shear.values[lane] = membranes[i].shear;
      damping_times_.push_back(membranes[i].damping_time);
    }
    is_damped_ = damping_times_.has_positive();
    // By the operations that find the lengths later, so that a body at rest feels no force at all.
    triangles_.for_each_batch(1, [&](int first) {
      membranes_[first / lane_count].rest_squared_length =
          materials::squared_lengths(materials::opposite_edges(triangles_.gather(first, rest)));
    });
  }

  std::string_view name() const override { return "membrane"; }
  bool is_membrane() const override { return true; }

  double energy(const Kinematics& state, int threads) override {
    return parallel_sum(static_cast<int>(membranes_.size()), threads, [&](int first, int last) {
      Lanes sum = 0;
      for (int batch = first; batch < last; ++batch) {
        sum += materials::membrane_energy(batch_of(lane_count * batch),
                                          triangles_.gather(lane_count * batch, state.position));
      }
      return materials::sum_of_lanes(sum);
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    triangles_.for_each_batch(threads, [&](int first) {
      triangles_.scatter(
          first,
          materials::membrane_forces(batch_of(first), triangles_.gather(first, state.position),
                                     triangles_.gather(first, state.velocity)),
          force);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    triangles_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { triangles_.attach(pattern); }

  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    const bool pull_only = definiteness == Definiteness::semi_definite;
    triangles_.for_each_batch(threads, [&](int first) {
      const TriangleMembraneOf<Lanes> membranes = batch_of(first);
      const NodesOf<Lanes, 3> x = triangles_.gather(first, state.position);
      const NodesOf<Lanes, 3> v = triangles_.gather(first, state.velocity);
      auto blocks = materials::membrane_material_stiffness(membranes, x);
      if (is_damped_ && into.is_joined()) {
        const NodesOf<Lanes, 3> pulls =
            materials::membrane_material_pulls(membranes, x, triangles_.gather(first, into.along));
        triangles_.scatter(first, NodesOf<Lanes, 3>(-membranes.damping_time * pulls), into.product);
        blocks.scale(1.0 + into.inverse_gamma * membranes.damping_time);
      } else if (is_damped_) {
        triangles_.scatter(first, blocks.scaled(membranes.damping_time), *into.damping);
      }
      const Vec3Of<Lanes> tensions =
          materials::edge_tensions(membranes, materials::opposite_edges(x), v);
      materials::add_membrane_stress(tensions, pull_only, blocks);
      triangles_.scatter(first, blocks, into.stiffness);
    });
  }

 private:
  TriangleMembraneOf<Lanes> batch_of(int first) const {
    const MembraneBatch& batch = membranes_[first / lane_count];
    return {batch.rest_squared_length, batch.root, batch.shear, damping_times_.batch(first)};
  }

  StencilArray<3> triangles_;
  std::vector<MembraneBatch> membranes_;
  StencilNumbers damping_times_;  // s
  bool is_damped_ = false;
};

Nodes3 gather(const std::array<int, 3>& triangle, std::span<const Vec3> values) {
  Nodes3 nodes;
  for (int i = 0; i < 3; ++i) nodes.col(i) = values[triangle[i]];
  return nodes;
}

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
  return std::make_unique<MembraneForce>(triangles, membranes, rest_positions(scene));
}

}  // namespace weft::sim
