// Membranes whose tension is a nonlinear function of the strain, given by curves or by measured
// coefficients.
#include "materials/fabric_membrane.h"

#include "sim/base/parallel.h"
#include "sim/base/prefetch.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/membrane_quads.h"
#include "sim/scene/cloth_laws.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

namespace {

using materials::EdgeModulusOf;
using materials::FabricMembrane;
using materials::FabricMembraneOf;
using materials::lane_count;
using materials::Lanes;
using materials::Mat3Of;
using materials::NodesOf;
using materials::Symmetric3Of;
using materials::Vec3Of;

using Corners = MembraneCorners;

// The force of the membranes of all dynamic bodies of one material.
template <class Law>
class FabricMembraneForce final : public Force {
 public:
  FabricMembraneForce(const Scene& scene, const MaterialCase& material, Law law)
      : law_(std::move(law)), damping_time_(material.membrane_damping_time()) {
    std::vector<Quad> corners;
    for (int b = 0; b < scene.dynamic_bodies; ++b) {
      const SceneBody& body = scene.bodies[b];
      if (body.material->name != material.name) continue;
      for_each_quad(body, [&](int q, const Quad& quad, const auto& rest) {
        for (int t = 0; t < 2; ++t)
          set_membrane(corners.size(), t, rest[t], warp_direction(body, 2 * q + t));
        corners.push_back(quad);
      });
    }
    const std::vector<Vec3> rest = rest_positions(scene);
    quads_ = MembraneStencils(corners, static_cast<int>(rest.size()));
    set_rest_lengths(rest);
    if (!damping_time_.varies()) set_damping_time(damping_time_.at({}));
  }

  std::string_view name() const override { return "membrane"; }
  bool has_damping() const override { return damping_time_.varies() || time_ > 0; }
  bool varies() const override { return damping_time_.varies(); }
  void set_time(const Instant& now) override { set_damping_time(damping_time_.at(now)); }
  double evaluation_work() const override { return 1.2; }
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
    quads_.for_each_batch(threads, [&](int first) {
      if (has_damping()) {
        add_damped_batch(first, state, force);
      } else {
        add_batch(first, state.position, force);
      }
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quads_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { quads_.attach(pattern); }

  // Adds K = G (A B^T w'' B) G^T + sum_i s_i d^2 q_i / dx dx and D = beta G (A B^T V B) G^T. The
  // q_i are the changes of squared edge lengths, and G = dq/dx. B maps q to strains, and the s_i
  // are the tensions. A is the area, w the energy per area, V the viscosity and beta the damping
  // time. The semi-definite form of K uses V in place of w'' and leaves out the terms with s_i < 0.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    const bool semi_definite = definiteness == Definiteness::semi_definite;
    quads_.for_each_batch(
        threads, [&](int first) { add_batch_derivatives(first, state, into, semi_definite); });
  }

 private:
  using Triangle = FabricMembraneOf<Lanes>;
  using Nodes = NodesOf<Lanes, 3>;

  void set_membrane(std::size_t quad, int t, const materials::Nodes3& rest, const Vec3& warp) {
    const auto lane = static_cast<int>(quad % lane_count);
    if (lane == 0 && t == 0) membranes_.emplace_back();
    const FabricMembrane membrane = materials::make_fabric_membrane(rest, warp, 0);
    Triangle& batch = membranes_.back()[t];
    for (int i = 0; i < 9; ++i)
      batch.strains.map.data()[i].values[lane] = membrane.strains.map.data()[i];
    batch.strains.area.values[lane] = membrane.strains.area;
  }
  // Computes rest lengths by the same operations as later lengths. The force on a body in its rest
  // shape is therefore exactly zero, unless damping acts.
  void set_rest_lengths(const std::vector<Vec3>& rest) {
    quads_.for_each_batch(1, [&](int first) {
      const Corners x = quads_.gather(first, rest);
      for (int t = 0; t < 2; ++t) {
        membranes_[first / lane_count][t].rest_squared_length =
            materials::squared_lengths(materials::opposite_edges(triangle_nodes(x, t)));
      }
    });
  }
  void set_damping_time(double time) {
    if (time == time_) return;
    time_ = time;
    for (auto& batch : membranes_) {
      for (Triangle& triangle : batch) triangle.damping_time = time;
    }
  }

  const Triangle& triangle(int first, int t) const { return membranes_[first / lane_count][t]; }

  WEFT_FLATTEN Lanes batch_energy(int first, std::span<const Vec3> position) const {
    const Corners x = quads_.gather(first, position);
    return materials::fabric_energy(triangle(first, 0), law_, triangle_nodes(x, 0)) +
           materials::fabric_energy(triangle(first, 1), law_, triangle_nodes(x, 1));
  }
  WEFT_FLATTEN void add_batch(int first, std::span<const Vec3> position,
                              std::span<Vec3> force) const {
    prefetch(membranes_, first / lane_count + 1);
    const Corners x = quads_.gather(first, position);
    const auto forces = [&](int t) {
      const Nodes edges = materials::opposite_edges(triangle_nodes(x, t));
      return materials::pulls_of(materials::fabric_tensions(triangle(first, t), law_, edges),
                                 edges);
    };
    quads_.scatter(first, sum_of(forces(0), forces(1)), force);
  }
  WEFT_FLATTEN void add_damped_batch(int first, const Kinematics& state,
                                     std::span<Vec3> force) const {
    prefetch(membranes_, first / lane_count + 1);
    const Corners x = quads_.gather(first, state.position);
    const Corners v = quads_.gather(first, state.velocity);
    const auto forces = [&](int t) {
      const Nodes edges = materials::opposite_edges(triangle_nodes(x, t));
      return materials::pulls_of(
          materials::fabric_tensions(triangle(first, t), law_, edges, triangle_nodes(v, t)), edges);
    };
    quads_.scatter(first, sum_of(forces(0), forces(1)), force);
  }

  WEFT_FLATTEN void add_batch_derivatives(int first, const Kinematics& state,
                                          const Derivatives& into, bool semi_definite) const {
    prefetch(membranes_, first / lane_count + 1);
    const Corners x = quads_.gather(first, state.position);
    QuadBlocks stiffness, damping;
    stiffness.blocks.fill(Mat3Of<Lanes>::Zero());
    if (has_damping() && !into.is_joined()) damping.blocks.fill(Mat3Of<Lanes>::Zero());
    std::array<Nodes, 2> pulls;  // minus D times `into.along`, by triangle
    for (int t = 0; t < 2; ++t) {
      const Triangle& own = triangle(first, t);
      const Nodes nodes = triangle_nodes(x, t), edges = materials::opposite_edges(nodes);
      const Vec3Of<Lanes> q = materials::squared_length_changes(own, edges);
      EdgeModulusOf<Lanes> tangent{materials::law_tangent(own.strains, law_, q, semi_definite)};
      Vec3Of<Lanes> tensions = materials::law_slope(own.strains, law_, q);
      if (has_damping()) {
        const Symmetric3Of<Lanes> viscosity =
            materials::law_viscosity(own.strains, law_, q).scaled(own.damping_time);
        const Corners v = quads_.gather(first, state.velocity);
        tensions += viscosity * materials::squared_length_rates(edges, triangle_nodes(v, t));
        if (into.is_joined()) {
          const Corners along = quads_.gather(first, into.along);
          pulls[t] =
              materials::pulls_of(Vec3Of<Lanes>(viscosity * materials::squared_length_rates(
                                                                edges, triangle_nodes(along, t))),
                                  edges);
          tangent.entries += viscosity.scaled(into.inverse_gamma);
        } else {
          add_triangle(
              materials::membrane_material_stiffness(EdgeModulusOf<Lanes>{viscosity}, nodes), t,
              damping);
        }
      }
      add_triangle(materials::membrane_material_stiffness(tangent, nodes), t, stiffness);
      add_stress(tensions, semi_definite, t, stiffness);
    }
    if (has_damping()) {
      if (into.is_joined()) {
        quads_.scatter(first, Corners(-sum_of(pulls[0], pulls[1])), into.product);
      } else {
        quads_.scatter(first, damping, *into.damping);
      }
    }
    quads_.scatter(first, stiffness, into.stiffness);
  }

  Law law_;
  TimeCurve<double> damping_time_;  // s
  double time_ = 0;                 // s, at the time of set_time()
  MembraneStencils quads_;
  // The membranes of both triangles of each quad, by batch. Lanes beyond the last quad have no
  // area.
  std::vector<std::array<Triangle, 2>> membranes_;
};

bool is_used(const Scene& scene, const MaterialCase& material) {
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    if (scene.bodies[b].material->name == material.name) return true;
  }
  return false;
}

}  // namespace

std::vector<std::unique_ptr<Force>> make_fabric_membrane_forces(const Scene& scene) {
  std::vector<std::unique_ptr<Force>> forces;
  for (const MaterialCase& material : scene.source.material) {
    if (material.has_isotropic_membrane() || !is_used(scene, material)) continue;
    const std::optional<StretchLaw> law = stretch_law(material);
    if (const auto* curves = std::get_if<materials::CurvedStretch>(&*law)) {
      forces.push_back(std::make_unique<FabricMembraneForce<materials::CurvedStretch>>(
          scene, material, *curves));
    } else if (const auto* measured = std::get_if<materials::MeasuredStretch>(&*law)) {
      forces.push_back(std::make_unique<FabricMembraneForce<materials::MeasuredStretch>>(
          scene, material, *measured));
    }
  }
  return forces;
}

}  // namespace weft::sim
