// The bending of cloth with any law over the angles of edges. Quads are evaluated in batches.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "materials/bending.h"
#include "sim/base/parallel.h"
#include "sim/base/prefetch.h"
#include "sim/forces/bending_quads.h"
#include "sim/forces/force.h"
#include "sim/forces/quad_hinges.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/varying_numbers.h"

namespace weft::sim {

// Base class of bending forces. It has the stencils, the damping times and the assembly of matrix
// blocks, which do not depend on the law.
class QuadBending : public Force {
 public:
  using Lanes = materials::Lanes;
  // Bending modulus (N m) of a triangle over the angles of its hinges.
  using Modulus = materials::Symmetric3Of<Lanes>;
  using Slopes = QuadSlopes<Lanes>;
  using Nodes = Slopes::Nodes;
  using Hinges = Slopes::Hinges;  // one number per hinge of a quad
  using HingeVectors = std::array<materials::HingeVectorsOf<Lanes>, hinge_count>;

  std::string_view name() const override { return "bending"; }
  bool has_damping() const override { return is_damped_; }
  bool varies() const override { return varying_times_.varies(); }
  void set_time(const Instant& now) override { varying_times_.update(now, damping_times_); }
  double evaluation_work() const override { return 1.2; }
  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quads_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { quads_.attach(pattern); }

  // Returns the numbers that belong to the three hinges of triangle t.
  static materials::Vec3Of<Lanes> of_triangle(const Hinges& numbers, int t) {
    const auto& hinges = hinged_triangles[t].hinges;
    return {numbers[hinges[0]], numbers[hinges[1]], numbers[hinges[2]]};
  }
  // Returns, for each hinge of a quad, the sum of the contributions of both triangles. of_one(t)
  // returns the contributions of triangle t to its three hinges.
  template <class OfTriangle>
  static Hinges sum_of_triangles(const OfTriangle& of_one) {
    Hinges sum;
    sum.fill(0);
    for (int t = 0; t < 2; ++t) {
      const materials::Vec3Of<Lanes> own = of_one(t);
      for (int i = 0; i < 3; ++i) sum[hinged_triangles[t].hinges[i]] += own[i];
    }
    return sum;
  }

 protected:
  QuadBending(const BendingQuads& quads, int particle_count);

  static HingeVectors hinge_vectors(const Nodes& x) {
    HingeVectors vectors;
    for (int h = 0; h < hinge_count; ++h) {
      materials::NodesOf<Lanes, 4> nodes;
      for (int k = 0; k < 4; ++k) nodes.col(k) = x.col(hinge_nodes[h][k]);
      vectors[h] = materials::hinge_vectors(nodes);
    }
    return vectors;
  }

  // Adds B^T C B for the batch of quads that starts at quad `first`. B = d theta / d x are the
  // slopes of the hinge angles theta, and C the moduli.
  void add_elastic(int first, const std::array<Modulus, 2>& moduli, const Slopes& slopes,
                   const BlockTarget& into) const;
  // Adds B^T C B + sum_h moment_h d^2 theta_h / dx dx for a batch, with the sum over its hinges h.
  void add_stressed(int first, const std::array<Modulus, 2>& moduli, const Slopes& slopes,
                    const Nodes& x, const Hinges& moments, BlockMatrix& matrix) const;
  // Adds the damping D = beta B^T V B of a batch, with its damping times beta and viscosities V. If
  // K and D are joined, adds the product D times `into.along` instead.
  void add_damping(int first, const std::array<Modulus, 2>& viscosities, const Slopes& slopes,
                   const Derivatives& into) const;

  StencilArray<QuadSurroundings::count, QuadSurroundings> quads_;
  VaryingNumbers varying_times_;
  StencilNumbers damping_times_;  // s, by quad, at the time of set_time()
  bool is_damped_ = false;        // true if damped at any time
};

// Bending with the law `Batch`. An object of type Batch has the laws of up to materials::lane_count
// consecutive quads. Strains are changes of the hinge angles from their rest values (rad). The
// energy W belongs to the two triangles of a quad, without the triangles beyond its sides.
//   Hinges rest_angles;                                       // rad
//   Lanes energy(strains) const;                              // W, J
//   Hinges moments(strains) const;                            // dW/d theta, N m
//   Hinges moments(strains, damping_time, rates) const;       // the damping moments included
//   std::array<Modulus, 2> viscosities(strains) const;        // V of each triangle, N m
//   static constexpr bool damps_like_stiffness;  // true if V is the semi-definite modulus
//   std::array<Modulus, 2> joined(strains, definiteness, inverse_gamma, damping_time) const;
//       // d^2 W/d theta d theta or, if semi-definite, V; plus V damping_time inverse_gamma
template <class Batch>
class BendingForce : public QuadBending {
 public:
  BendingForce(const BendingQuads& quads, std::vector<Batch> batches, const std::vector<Vec3>& rest)
      : QuadBending(quads, static_cast<int>(rest.size())), batches_(std::move(batches)) {
    // Rest angles are computed by the same operations as later angles. The force on a body in its
    // rest shape is therefore exactly zero, unless damping acts.
    quads_.for_each_batch(1, [&](int first) {
      Batch& batch = batches_[first / materials::lane_count];
      batch.rest_angles.fill(0);
      batch.rest_angles = strains_of(batch, hinge_vectors(quads_.gather(first, rest)));
    });
  }

  double energy(const Kinematics& state, int threads) override {
    return parallel_sum(static_cast<int>(batches_.size()), threads, [&](int first, int last) {
      Lanes sum = 0;
      for (int batch = first; batch < last; ++batch)
        sum += batch_energy(materials::lane_count * batch, state.position);
      return materials::sum_of_lanes(sum);
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    quads_.for_each_batch(threads, [&](int first) { add_batch(first, state, force); });
  }

  // Adds K = B^T C B + sum_h moment_h d^2 theta_h / dx dx and D = beta B^T V B, with the hinge
  // angles theta and B = d theta / dx. The semi-definite form of K leaves out the sum and uses the
  // viscosity V in place of the tangent modulus C. The sum has no term for a hinge beside a
  // triangle without area.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    quads_.for_each_batch(
        threads, [&](int first) { add_batch_derivatives(first, state, into, definiteness); });
  }

 protected:
  std::vector<Batch>& batches() { return batches_; }
  Hinges strains_at(int first, std::span<const Vec3> position) const {
    return strains_of(batch_of(first), hinge_vectors(quads_.gather(first, position)));
  }

 private:
  const Batch& batch_of(int first) const { return batches_[first / materials::lane_count]; }

  // Returns the strains theta - theta_rest of a batch, rad.
  static Hinges strains_of(const Batch& batch, const HingeVectors& hinges) {
    Hinges strains;
    for (int h = 0; h < hinge_count; ++h)
      strains[h] = materials::hinge_angle(hinges[h]) - batch.rest_angles[h];
    return strains;
  }
  // Returns the moments of the hinges at the given strains, N m. Damping moments are included.
  Hinges moments(int first, const Hinges& strains, const Slopes& slopes,
                 const Kinematics& state) const {
    if (!is_damped_) return batch_of(first).moments(strains);
    return batch_of(first).moments(strains, damping_times_.batch(first),
                                   slopes.along(quads_.gather(first, state.velocity)));
  }

  WEFT_FLATTEN Lanes batch_energy(int first, std::span<const Vec3> position) const {
    return batch_of(first).energy(strains_at(first, position));
  }
  WEFT_FLATTEN void add_batch(int first, const Kinematics& state, std::span<Vec3> force) const {
    prefetch(batches_, first / materials::lane_count + 1);
    const HingeVectors hinges = hinge_vectors(quads_.gather(first, state.position));
    const Slopes slopes(hinges);
    Hinges pulls = moments(first, strains_of(batch_of(first), hinges), slopes, state);
    for (Lanes& pull : pulls) pull = -pull;
    quads_.scatter(first, slopes.times(pulls), force);
  }

  WEFT_FLATTEN void add_batch_derivatives(int first, const Kinematics& state,
                                          const Derivatives& into,
                                          Definiteness definiteness) const {
    prefetch(batches_, first / materials::lane_count + 1);
    const Batch& batch = batch_of(first);
    const Nodes x = quads_.gather(first, state.position);
    const HingeVectors hinges = hinge_vectors(x);
    const Slopes slopes(hinges);
    const Hinges strains = strains_of(batch, hinges);
    if (Batch::damps_like_stiffness && is_damped_ && !into.is_joined() &&
        definiteness == Definiteness::semi_definite) {
      return add_elastic(first, batch.viscosities(strains), slopes,
                         {into.stiffness, into.damping, damping_times_.batch(first)});
    }
    if (is_damped_) add_damping(first, batch.viscosities(strains), slopes, into);
    const std::array<Modulus, 2> moduli =
        batch.joined(strains, definiteness, into.inverse_gamma,
                     is_damped_ ? Lanes(damping_times_.batch(first)) : Lanes(0));
    if (definiteness == Definiteness::semi_definite)
      return add_elastic(first, moduli, slopes, {into.stiffness});
    Hinges stress = moments(first, strains, slopes, state);
    for (int h = 0; h < hinge_count; ++h)
      stress[h] = materials::choose(hinges[h].flat_triangle, 0.0, stress[h]);
    add_stressed(first, moduli, slopes, x, stress, into.stiffness);
  }

  std::vector<Batch> batches_;
};

}  // namespace weft::sim
