// The limit of the principal stretches of cloth (materials/strain_limit.h).
#include "materials/strain_limit.h"

#include "sim/base/parallel.h"
#include "sim/case/membrane_stiffness.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/membrane_quads.h"

namespace weft::sim {

namespace {

using materials::lane_count;
using materials::Lanes;
using materials::Mat3Of;
using materials::NodesOf;
using materials::StrainLimit;
using materials::StrainLimitOf;

using Corners = MembraneCorners;
using LimitedTriangles = std::array<StrainLimitOf<Lanes>, 2>;  // of a batch of quads

struct LimitedQuads {
  std::vector<Quad> corners;
  std::vector<std::array<StrainLimit, 2>> triangles;
};

class StrainLimitForce final : public Force {
 public:
  StrainLimitForce(const LimitedQuads& quads, int particle_count)
      : quads_(quads.corners, particle_count),
        batches_((quads.triangles.size() + lane_count - 1) / lane_count) {
    for (std::size_t i = 0; i < quads.triangles.size(); ++i) {
      const std::size_t lane = i % lane_count;
      for (int t = 0; t < 2; ++t) {
        const StrainLimit& limit = quads.triangles[i][t];
        StrainLimitOf<Lanes>& batch = batches_[i / lane_count][t];
        for (int node = 0; node < 2; ++node) {
          for (int k = 0; k < 2; ++k)
            batch.gradients[node][k].values[lane] = limit.gradients[node][k];
        }
        batch.onset.values[lane] = limit.onset;
        batch.range.values[lane] = limit.range;
        batch.stiffness.values[lane] = limit.stiffness;
      }
    }
  }

  std::string_view name() const override { return "strain_limit"; }
  bool is_membrane() const override { return true; }
  bool is_constraint() const override { return true; }
  bool has_damping() const override { return false; }
  bool has_limits() const override { return true; }
  double evaluation_work() const override { return 0.4; }

  double energy(const Kinematics& state, int threads) override {
    return parallel_sum(static_cast<int>(batches_.size()), threads, [&](int first, int last) {
      Lanes sum = 0;
      for (int batch = first; batch < last; ++batch)
        sum += batch_energy(lane_count * batch, state.position);
      return materials::sum_of_lanes(sum);
    });
  }

  int find_beyond_limit(std::span<const Vec3> position) const override {
    for (int first = 0; first < quads_.count(); first += lane_count) {
      const int lane = lane_beyond_limit(first, position);
      if (lane >= 0) return quads_[std::min(first + lane, quads_.count() - 1)][0];
    }
    return -1;
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    quads_.for_each_batch(threads, [&](int first) { add_batch(first, state.position, force); });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quads_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { quads_.attach(pattern); }

  // The energy is convex: the exact stiffness is semi-definite.
  void add_derivatives(const Kinematics& state, const Derivatives& into,
                       Definiteness /*definiteness*/, int threads) override {
    quads_.for_each_batch(
        threads, [&](int first) { add_batch_stiffness(first, state.position, into.stiffness); });
  }

 private:
  // True if no triangle of the batch has reached the onset of its limit.
  static bool is_slack(const LimitedTriangles& triangles, const Corners& x) {
    bool slack = true;
    for (int t = 0; t < 2; ++t) {
      const Lanes over = materials::largest_squared_stretch(triangles[t], triangle_nodes(x, t)) -
                         triangles[t].onset;
      for (int lane = 0; lane < lane_count; ++lane) slack &= !(over.values[lane] > 0);
    }
    return slack;
  }

  WEFT_FLATTEN Lanes batch_energy(int first, std::span<const Vec3> position) const {
    const LimitedTriangles& triangles = batches_[first / lane_count];
    const Corners x = quads_.gather(first, position);
    if (is_slack(triangles, x)) return 0;
    return materials::strain_limit_energy(triangles[0], triangle_nodes(x, 0)) +
           materials::strain_limit_energy(triangles[1], triangle_nodes(x, 1));
  }

  // Returns the first lane of the batch whose quad exceeds its limit, or -1. A quad with a position
  // that is not finite exceeds it.
  WEFT_FLATTEN int lane_beyond_limit(int first, std::span<const Vec3> position) const {
    const LimitedTriangles& triangles = batches_[first / lane_count];
    const Corners x = quads_.gather(first, position);
    std::array<Lanes, 2> left;
    for (int t = 0; t < 2; ++t) {
      left[t] = materials::limit_of_squared_stretch(triangles[t]) -
                materials::largest_squared_stretch(triangles[t], triangle_nodes(x, t));
    }
    for (int lane = 0; lane < lane_count; ++lane) {
      if (!(left[0].values[lane] > 0) || !(left[1].values[lane] > 0)) return lane;
    }
    return -1;
  }

  WEFT_FLATTEN void add_batch(int first, std::span<const Vec3> position,
                              std::span<Vec3> force) const {
    const LimitedTriangles& triangles = batches_[first / lane_count];
    const Corners x = quads_.gather(first, position);
    if (is_slack(triangles, x)) return;
    const auto forces = [&](int t) {
      return materials::strain_limit_forces(triangles[t], triangle_nodes(x, t));
    };
    quads_.scatter(first, sum_of(forces(0), forces(1)), force);
  }

  WEFT_FLATTEN void add_batch_stiffness(int first, std::span<const Vec3> position,
                                        BlockMatrix& matrix) const {
    const LimitedTriangles& triangles = batches_[first / lane_count];
    const Corners x = quads_.gather(first, position);
    if (is_slack(triangles, x)) return;
    QuadBlocks sum;
    sum.blocks.fill(Mat3Of<Lanes>::Zero());
    for (int t = 0; t < 2; ++t)
      add_triangle(materials::strain_limit_stiffness(triangles[t], triangle_nodes(x, t)), t, sum);
    quads_.scatter(first, sum, matrix);
  }

  MembraneStencils quads_;
  std::vector<LimitedTriangles> batches_;  // lanes beyond the last quad have no stiffness
};

LimitedQuads limited_quads(const Scene& scene) {
  LimitedQuads quads;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    if (!body.material->strain_limit) continue;
    const double limit = *body.material->strain_limit;
    const double stiffness = largest_membrane_stiffness(*body.material);
    for_each_quad(body, [&](int /*quad*/, const Quad& corners, const auto& rest) {
      quads.corners.push_back(corners);
      auto& triangles = quads.triangles.emplace_back();
      for (int t = 0; t < 2; ++t)
        triangles[t] = materials::make_strain_limit(rest[t], limit, stiffness);
    });
  }
  return quads;
}

}  // namespace

std::unique_ptr<Force> make_strain_limit_force(const Scene& scene) {
  const LimitedQuads quads = limited_quads(scene);
  if (quads.corners.empty()) return nullptr;
  return std::make_unique<StrainLimitForce>(quads, scene.dynamic_particles);
}

}  // namespace weft::sim
