#include "materials/membrane.h"

#include "materials/orthotropic_membrane.h"
#include "sim/base/parallel.h"
#include "sim/base/prefetch.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/force_group.h"
#include "sim/forces/membrane_quads.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/cloth_laws.h"

namespace weft::sim {

namespace {

using materials::lane_count;
using materials::Lanes;
using materials::Mat3Of;
using materials::NodesOf;
using materials::OrthotropicMembraneOf;
using materials::TriangleMembraneOf;

using Corners = MembraneCorners;

// Quads, and the membranes of their triangles. The membranes are isotropic (TriangleMembraneOf) or
// orthotropic (OrthotropicMembraneOf).
template <template <class> class MembraneOf>
struct MembraneQuads {
  std::vector<Quad> corners;
  std::vector<std::array<MembraneOf<double>, 2>> membranes;
  VaryingNumbers damping_times;  // s, by quad
  bool is_damped = false;        // true if damped at any time
};

void set_modulus(int lane, const TriangleMembraneOf<double>& membrane,
                 TriangleMembraneOf<Lanes>& batch) {
  for (int k = 0; k < 3; ++k) batch.root[k].values[lane] = membrane.root[k];
  batch.shear.values[lane] = membrane.shear;
}
void set_modulus(int lane, const OrthotropicMembraneOf<double>& membrane,
                 OrthotropicMembraneOf<Lanes>& batch) {
  for (std::size_t k = 0; k < 6; ++k)
    batch.edge_modulus.entries[k].values[lane] = membrane.edge_modulus.entries[k];
}

// The force of membranes whose tension is linear in the Green strain.
template <template <class> class MembraneOf>
class MembraneForce final : public Force {
 public:
  MembraneForce(const MembraneQuads<MembraneOf>& quads, const std::vector<Vec3>& rest)
      : quads_(quads.corners, static_cast<int>(rest.size())),
        damping_times_(quads.damping_times),
        is_damped_(quads.is_damped) {
    membranes_.resize((quads.membranes.size() + lane_count - 1) / lane_count);
    for (std::size_t i = 0; i < quads.membranes.size(); ++i) {
      const int lane = static_cast<int>(i % lane_count);
      for (int t = 0; t < 2; ++t) {
        MembraneOf<Lanes>& batch = membranes_[i / lane_count][t];
        set_modulus(lane, quads.membranes[i][t], batch);
        batch.damping_time.values[lane] = quads.membranes[i][t].damping_time;
      }
    }
    // Rest lengths are computed by the same operations as later lengths. The force on a body in its
    // rest shape is therefore exactly zero, unless damping acts.
    quads_.for_each_batch(1, [&](int first) {
      const Corners x = quads_.gather(first, rest);
      for (int t = 0; t < 2; ++t) {
        membranes_[first / lane_count][t].rest_squared_length =
            materials::squared_lengths(materials::opposite_edges(triangle_nodes(x, t)));
      }
    });
  }

  std::string_view name() const override { return "membrane"; }
  bool has_damping() const override { return is_damped_; }
  bool varies() const override { return damping_times_.varies(); }
  void set_time(const Instant& now) override {
    damping_times_.visit_changed(now, [&](int first, int last, double time) {
      for (int i = first; i < last; ++i) {
        for (MembraneOf<Lanes>& membrane : membranes_[i / lane_count])
          membrane.damping_time.values[i % lane_count] = time;
      }
    });
  }
  double evaluation_work() const override { return 0.3; }
  bool is_membrane() const override { return true; }

  double energy(const Kinematics& state, int threads) override {
    return parallel_sum(static_cast<int>(membranes_.size()), threads, [&](int first, int last) {
      Lanes sum = 0;
      for (int batch = first; batch < last; ++batch)
        sum += batch_energy(lane_count * batch, state.position);
      return materials::sum_of_lanes(sum);
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    if (is_damped_) {
      quads_.for_each_batch(threads, [&](int first) { add_batch(first, state, force); });
    } else {
      quads_.for_each_chunk(threads, [&](int first, int last) {
        add_undamped_chunk(first, last, state.position, force);
      });
    }
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quads_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { quads_.attach(pattern); }

  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    const bool pull_only = definiteness == Definiteness::semi_definite;
    quads_.for_each_batch(threads,
                          [&](int first) { add_batch_derivatives(first, state, into, pull_only); });
  }

 private:
  // WEFT_FLATTEN (stencil_array.h) inlines the calls in a function, because calls would pass
  // vectors through memory.
  WEFT_FLATTEN Lanes batch_energy(int first, std::span<const Vec3> position) const {
    if (quads_.is_run(first)) return energy_of(first, quads_.gather_run(first, position));
    return energy_of(first, quads_.gather(first, position));
  }
  Lanes energy_of(int first, const Corners& x) const {
    const auto& [one, other] = membranes_[first / lane_count];
    return materials::membrane_energy(one, triangle_nodes(x, 0)) +
           materials::membrane_energy(other, triangle_nodes(x, 1));
  }
  WEFT_FLATTEN void add_batch(int first, const Kinematics& state, std::span<Vec3> force) const {
    prefetch(membranes_, first / lane_count + 1);
    const Corners x = quads_.gather(first, state.position);
    const Corners v = quads_.gather(first, state.velocity);
    const auto& [one, other] = membranes_[first / lane_count];
    quads_.scatter(
        first,
        sum_of(materials::membrane_forces(one, triangle_nodes(x, 0), triangle_nodes(v, 0)),
               materials::membrane_forces(other, triangle_nodes(x, 1), triangle_nodes(v, 1))),
        force);
  }
  WEFT_FLATTEN void add_undamped_chunk(int first, int last, std::span<const Vec3> position,
                                       std::span<Vec3> force) const {
    MembraneStencils::RunScatter run = quads_.scatter_runs(force);
    for (int batch = first; batch < last; batch += lane_count) {
      prefetch(membranes_, batch / lane_count + 1);
      if (quads_.is_run(batch)) {
        run.add(batch, undamped_forces(batch, quads_.gather_run(batch, position)));
      } else {
        add_scattered_batch(batch, position, force);
      }
    }
    run.finish();
  }
  [[gnu::noinline]] void add_scattered_batch(int first, std::span<const Vec3> position,
                                             std::span<Vec3> force) const {
    quads_.scatter(first, undamped_forces(first, quads_.gather(first, position)), force);
  }
  Corners undamped_forces(int first, const Corners& x) const {
    const auto& [one, other] = membranes_[first / lane_count];
    return materials::undamped_membrane_forces(one, other, x);
  }

  WEFT_FLATTEN void add_batch_derivatives(int first, const Kinematics& state,
                                          const Derivatives& into, bool pull_only) const {
    prefetch(membranes_, first / lane_count + 1);
    const Corners x = quads_.gather(first, state.position);
    const Corners v = quads_.gather(first, state.velocity);
    QuadBlocks blocks = material_blocks(first, x);
    if (is_damped_) scatter_damping(first, x, into, blocks);
    for (int t = 0; t < 2; ++t) {
      const NodesOf<Lanes, 3> nodes = triangle_nodes(x, t);
      add_stress(materials::edge_tensions(membranes_[first / lane_count][t],
                                          materials::opposite_edges(nodes), triangle_nodes(v, t)),
                 pull_only, t, blocks);
    }
    quads_.scatter(first, blocks, into.stiffness);
  }

  // Returns the blocks of G C G^T of both triangles (materials/membrane.h).
  QuadBlocks material_blocks(int first, const Corners& x) const {
    QuadBlocks blocks;
    blocks.blocks.fill(Mat3Of<Lanes>::Zero());
    for (int t = 0; t < 2; ++t) {
      add_triangle(materials::membrane_material_stiffness(membranes_[first / lane_count][t],
                                                          triangle_nodes(x, t)),
                   t, blocks);
    }
    return blocks;
  }

  // Adds D = beta `blocks` to the damping matrix. If K and D are joined, multiplies `blocks` by 1 +
  // beta / gamma and adds D times `into.along` to `into.product` instead. The damping time beta is
  // that of the quad, so both triangles have it.
  void scatter_damping(int first, const Corners& x, const Derivatives& into,
                       QuadBlocks& blocks) const {
    const auto& [one, other] = membranes_[first / lane_count];
    if (!into.is_joined()) {
      quads_.scatter(first, blocks.scaled(one.damping_time), *into.damping);
      return;
    }
    const Corners along = quads_.gather(first, into.along);
    const Corners pulls = sum_of(
        materials::membrane_material_pulls(one, triangle_nodes(x, 0), triangle_nodes(along, 0)),
        materials::membrane_material_pulls(other, triangle_nodes(x, 1), triangle_nodes(along, 1)));
    quads_.scatter(first, Corners(-one.damping_time * pulls), into.product);
    blocks.scale(1.0 + into.inverse_gamma * one.damping_time);
  }

  MembraneStencils quads_;
  // The membranes of both triangles of each quad, by batch. Lanes beyond the last quad have no
  // stiffness.
  std::vector<std::array<MembraneOf<Lanes>, 2>> membranes_;
  VaryingNumbers damping_times_;  // s, by quad
  bool is_damped_ = false;        // true if damped at any time
};

// Returns the force of all dynamic bodies with a material for which selects(material) is true; null
// if there are no such bodies. make(body, triangle, rest positions of its nodes) returns the
// membrane of a triangle.
template <template <class> class MembraneOf, class Selects, class Make>
std::unique_ptr<Force> force_of(const Scene& scene, const Selects& selects, const Make& make) {
  MembraneQuads<MembraneOf> quads;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const MaterialCase& material = *body.material;
    if (!selects(material)) continue;
    quads.damping_times.append(quad_count(body), material.membrane_damping_time());
    quads.is_damped |= !material.membrane_damping_time().is_zero();
    for_each_quad(body, [&](int q, const Quad& corners, const auto& rest) {
      quads.corners.push_back(corners);
      auto& membranes = quads.membranes.emplace_back();
      for (int t = 0; t < 2; ++t) membranes[t] = make(body, 2 * q + t, rest[t]);
    });
  }
  if (quads.corners.empty()) return nullptr;
  return std::make_unique<MembraneForce<MembraneOf>>(quads, rest_positions(scene));
}

std::unique_ptr<Force> make_isotropic(const Scene& scene) {
  const auto selects = [](const MaterialCase& material) {
    return !material.is_shell() && material.membrane == MembraneModel::triangles &&
           material.has_isotropic_membrane() && material.membrane_stiffness != 0;
  };
  return force_of<TriangleMembraneOf>(
      scene, selects, [](const SceneBody& body, int /*triangle*/, const materials::Nodes3& rest) {
        const MaterialCase& material = *body.material;
        return materials::make_triangle_membrane(
            rest, material.membrane_stiffness, material.poisson_ratio,
            material.membrane_damping_time().constant_or_zero());
      });
}

std::unique_ptr<Force> make_orthotropic(const Scene& scene) {
  const auto selects = [](const MaterialCase& material) {
    return material.orthotropic_membrane && !material.orthotropic_membrane->has_curves();
  };
  return force_of<OrthotropicMembraneOf>(
      scene, selects, [](const SceneBody& body, int triangle, const materials::Nodes3& rest) {
        const MaterialCase& material = *body.material;
        return materials::make_orthotropic_membrane(
            rest, warp_direction(body, triangle),
            std::get<materials::LinearLaw>(*stretch_law(material)).moduli,
            material.membrane_damping_time().constant_or_zero());
      });
}

}  // namespace

std::unique_ptr<Force> make_membrane_force(const Scene& scene) {
  std::vector<std::unique_ptr<Force>> members = make_fabric_membrane_forces(scene);
  members.insert(members.begin(), make_orthotropic(scene));
  members.insert(members.begin(), make_isotropic(scene));
  return grouped(std::move(members));
}

}  // namespace weft::sim
