// Energy, forces and derivatives of the elastic joints between patches of shells.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "materials/surface_angle.h"
#include "sim/forces/force.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/patch_joints.h"
#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// Stiffness of a joint per length of border, in units of D / w. D is the bending stiffness of the
// shell, and w the width of the elements at the border. The joint bends like a strip of the shell
// of width w / joint_hardness (docs/decisions/0051).
inline constexpr double joint_hardness = 1e3;

// The joints of all dynamic shells of one degree. At each point of a joint, the change of the angle
// between the two patches has an elastic energy (materials/surface_angle.h). The points are the
// joint points of the border's spline, about one per element.
template <int degree>
class ShellJoints {
 public:
  static constexpr int nodes = 3 * (degree + 1);
  using Stencil = std::array<int, nodes>;
  using Basis = materials::AngleBasis<nodes>;
  using Nodes = materials::NodesOf<double, nodes>;
  using Blocks = materials::StencilMatrix<double, nodes>;

  void add_body(const SceneBody& body) {
    const int before = static_cast<int>(stencils_.size());
    for (const PatchJoint& joint : find_patch_joints(body.atlas)) add_joint(body, joint);
    const int added = static_cast<int>(stencils_.size()) - before;
    const Varying<double> time = body.material->bending_damping_time();
    damping_.append(added, time);
    damping_time_.resize(stencils_.size(), time.constant_or_zero());
    is_damped_ |= added > 0 && !time.is_zero();
  }
  // Must be called once, after the last add_body().
  void finish(int particle_count) {
    points_ = StencilArray<nodes>(stencils_, particle_count);
    set_time({});
  }

  bool is_empty() const { return stencils_.empty(); }
  int count() const { return points_.count(); }
  bool is_damped() const { return is_damped_; }
  bool varies() const { return damping_.varies(); }
  void set_time(const Instant& now) {
    damping_.visit_changed(now, [&](int first, int last, double time) {
      std::fill(damping_time_.begin() + first, damping_time_.begin() + last, time);
    });
  }

  double energy(std::span<const Vec3> position, int first, int last) const {
    double sum = 0;
    for (int i = first; i < last; ++i)
      sum += SurfaceAngle(bases_[i], gather(i, position)).energy(laws_[i]);
    return sum;
  }
  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) const {
    points_.for_each(threads, [&](int i) {
      const SurfaceAngle angle(bases_[i], gather(i, state.position));
      const Nodes gradient = angle.gradient(bases_[i]);
      scatter(i, -moment(i, angle, gradient, state.velocity) * gradient, force);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const {
    points_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) { points_.attach(pattern); }
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) const {
    points_.for_each(threads, [&](int i) {
      const SurfaceAngle angle(bases_[i], gather(i, state.position));
      const Nodes gradient = angle.gradient(bases_[i]);
      const bool exact = definiteness == Definiteness::exact;
      const double damping = damping_time_[i] * laws_[i].stiffness;
      double slope = angle.moment_slope(laws_[i]);
      if (!exact) slope = std::max(slope, 0.0);
      if (into.is_joined()) slope += into.inverse_gamma * damping;
      Blocks stiffness = product(slope, gradient);
      if (exact)
        angle.add_hessian(moment(i, angle, gradient, state.velocity), bases_[i], stiffness);
      points_.add_blocks(i, stiffness, into.stiffness);
      if (!is_damped_) return;
      if (!into.is_joined())
        return points_.add_blocks(i, product(damping, gradient), *into.damping);
      const double rate = gradient.cwiseProduct(gather(i, into.along)).sum();
      scatter(i, damping * rate * gradient, into.product);
    });
  }

 private:
  using SurfaceAngle = materials::SurfaceAngle;

  void add_joint(const SceneBody& body, const PatchJoint& joint) {
    const SplineAxis axis(degree, static_cast<int>(joint.border.size()), joint.is_closed);
    for (const QuadraturePoint& at : axis.joint_points()) {
      const SplineBasis along = axis.at(at.parameter);
      Stencil& stencil = stencils_.emplace_back();
      Basis& basis = bases_.emplace_back();
      Nodes rest;
      for (int i = 0; i <= degree; ++i) {
        const int point = axis.control_point(along.element, i);
        const std::array<int, 3> particles{joint.border[point], joint.first[point],
                                           joint.second[point]};
        // At an open end, the slope of a spline is its degree times the first difference.
        const double across = degree * along.value[i];
        set(basis, i, {along.slope[i], -across, -across});
        set(basis, i + degree + 1, {0, across, 0});
        set(basis, i + 2 * (degree + 1), {0, 0, across});
        for (int k = 0; k < 3; ++k) {
          const int node = i + k * (degree + 1);
          stencil[node] = body.first_particle + particles[k];
          rest.col(node) = body.rest[particles[k]];
        }
      }
      const SurfaceAngle angle(basis, rest);
      const double length = angle.length() * at.weight;
      laws_.push_back({joint_hardness * rigidity(*body.material) / angle.width() * length,
                       angle.cosine(), angle.sine()});
    }
  }
  static double rigidity(const MaterialCase& material) {
    const double h = material.shell_thickness, nu = material.poisson_ratio;
    return material.youngs_modulus * h * h * h / (12 * (1 - nu * nu));
  }
  static void set(Basis& basis, int node, const std::array<double, 3>& coefficients) {
    basis.t[node] = coefficients[0];
    basis.a[node] = coefficients[1];
    basis.b[node] = coefficients[2];
  }

  Nodes gather(int point, std::span<const Vec3> values) const {
    Nodes result;
    for (int i = 0; i < nodes; ++i) result.col(i) = values[stencils_[point][i]];
    return result;
  }
  void scatter(int point, const Nodes& values, std::span<Vec3> sums) const {
    for (int i = 0; i < nodes; ++i) sums[stencils_[point][i]] += values.col(i);
  }
  // Returns the moment (N m) at a point, damping moment included.
  double moment(int point, const SurfaceAngle& angle, const Nodes& gradient,
                std::span<const Vec3> velocity) const {
    const double elastic = angle.moment(laws_[point]);
    if (!is_damped_) return elastic;
    const double rate = gradient.cwiseProduct(gather(point, velocity)).sum();
    return elastic + damping_time_[point] * laws_[point].stiffness * rate;
  }
  static Blocks product(double factor, const Nodes& gradient) {
    Blocks blocks;
    for (int r = 0; r < nodes; ++r) {
      for (int s = r; s < nodes; ++s)
        blocks(r, s) = factor * gradient.col(r) * gradient.col(s).transpose();
    }
    return blocks;
  }

  std::vector<Stencil> stencils_;
  std::vector<Basis> bases_;
  std::vector<materials::AngleLaw> laws_;
  StencilArray<nodes> points_;
  VaryingNumbers damping_;
  std::vector<double> damping_time_;  // s, by point, at the time of set_time()
  bool is_damped_ = false;            // true if damped at any time
};

}  // namespace weft::sim
