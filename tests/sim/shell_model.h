// Equilibria of single shells by Newton's method with a factorised tangent: an oracle that shares
// the forces of the shell with the integrators, and nothing else.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/forces/force.h"
#include "sim/motion/dynamics.h"
#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// Returns the text of a case with one shell, "shell", without contact.
inline std::string shell_case(double youngs_modulus, double poisson_ratio, double thickness,
                              const std::string& shape, const std::string& more = "") {
  return "[contact]\nenabled = false\n[material.solid]\nmodel = \"shell\"\nyoungs_modulus = " +
         std::to_string(youngs_modulus) + "\npoisson_ratio = " + std::to_string(poisson_ratio) +
         "\nshell_thickness = " + std::to_string(thickness) +
         "\nvolume_density = 1000\n[[body]]\nname = \"shell\"\nshape = { " + shape + " }\n" + more;
}

class ShellModel {
 public:
  using Loads = Eigen::VectorXd;  // N, three per control point

  explicit ShellModel(const std::string& text)
      : scene_(build_scene(parse_case(text, "test.toml"))),
        forces_(make_forces(*scene_)),
        x_(scene_->initial_position),
        is_held_(3 * x_.size(), 0) {
    std::vector<std::vector<int>> neighbours(x_.size());
    for (const auto& force : forces_) force->add_couplings(neighbours);
    pattern_ = std::make_shared<const BlockPattern>(neighbours);
    for (const auto& force : forces_) force->attach(*pattern_);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      if (!scene_->is_free(static_cast<int>(i))) hold(static_cast<int>(i), {0, 1, 2});
    }
  }

  const Scene& scene() const { return *scene_; }
  const SceneBody& body() const { return scene_->bodies[0]; }
  const std::vector<Vec3>& x() const { return x_; }
  int at(int row, int col) const {
    const bsi::Patch& patch = body().atlas.patches()[0];
    return body().atlas.particle(0, row < 0 ? patch.rows + row : row,
                                 col < 0 ? patch.cols + col : col);
  }
  void hold(int particle, std::initializer_list<int> axes) {
    for (const int axis : axes) is_held_[3 * particle + axis] = 1;
  }
  // Makes the difference of two control points keep its value along an axis.
  void tie(int a, int b, int axis, double stiffness) { ties_.push_back({a, b, axis, stiffness}); }

  Loads no_load() const { return Loads::Zero(static_cast<Eigen::Index>(3 * x_.size())); }
  // Adds a force (N) at a place of the surface.
  void add_force(const SplineSurface::Place& place, const Vec3& force, Loads& loads) const {
    const SplineSurface::Point point = body().spline->at(body().atlas, place);
    for (std::size_t i = 0; i < point.value.size(); ++i)
      loads.segment<3>(3 * point.control_points[i]) += point.value[i] * force;
  }
  Vec3 position(double u, double v) const {
    return body().spline->at(body().atlas, {0, u, v}).position(x_);
  }
  double length_u() const { return body().spline->patches()[0].u.elements(); }
  double length_v() const { return body().spline->patches()[0].v.elements(); }

  // Finds the equilibrium under dead loads. Returns the number of iterations; 0: not found.
  int solve(const Loads& loads, double size) {
    for (int iteration = 1; iteration <= 60; ++iteration) {
      const Loads step = newton_step(loads);
      const double largest = step.cwiseAbs().maxCoeff();
      if (!std::isfinite(largest)) return 0;
      const double fraction = std::min(1.0, 0.3 * size / largest);
      for (std::size_t i = 0; i < x_.size(); ++i)
        x_[i] += fraction * Vec3(step.segment<3>(static_cast<Eigen::Index>(3 * i)));
      if (largest < 1e-9 * size) return iteration;
    }
    return 0;
  }

  // Returns the tangent stiffness (N/m) of all control points, without supports.
  Eigen::MatrixXd tangent() const {
    const std::vector<Vec3> rest(x_.size(), Vec3::Zero());
    BlockMatrix stiffness(pattern_);
    for (const auto& each : forces_)
      each->add_derivatives({x_, rest}, {stiffness, &stiffness}, Definiteness::exact, 1);
    const auto size = static_cast<Eigen::Index>(3 * x_.size());
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size, size);
    for (int i = 0; i < pattern_->rows(); ++i) {
      for (int slot = pattern_->row_begin(i); slot < pattern_->row_end(i); ++slot)
        all.block<3, 3>(3 * i, 3 * pattern_->column(slot)) = stiffness.block(i, slot);
    }
    return all;
  }

 private:
  struct Tie {
    int a, b, axis;
    double stiffness;
  };

  Loads newton_step(const Loads& loads) {
    const std::vector<Vec3> rest(x_.size(), Vec3::Zero());
    std::vector<Vec3> force(x_.size(), Vec3::Zero());
    BlockMatrix stiffness(pattern_);
    for (const auto& each : forces_) {
      each->add_forces({x_, rest}, force, 1);
      each->add_derivatives({x_, rest}, {stiffness, &stiffness}, Definiteness::exact, 1);
    }
    Loads residual = loads + Eigen::Map<const Loads>(force[0].data(), loads.size());
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](int row, int column, double value) {
      if (is_held_[row] == 0 && is_held_[column] == 0) entries.emplace_back(row, column, value);
    };
    for (int i = 0; i < pattern_->rows(); ++i) {
      for (int slot = pattern_->row_begin(i); slot < pattern_->row_end(i); ++slot) {
        const Mat3 block = stiffness.block(i, slot);
        for (int a = 0; a < 3; ++a) {
          for (int b = 0; b < 3; ++b) add(3 * i + a, 3 * pattern_->column(slot) + b, block(a, b));
        }
      }
    }
    for (const auto& [a, b, axis, strength] : ties_) {
      const int first = 3 * a + axis, second = 3 * b + axis;
      const std::vector<Vec3>& start = scene_->initial_position;
      const double pull = strength * ((x_[b] - x_[a])[axis] - (start[b] - start[a])[axis]);
      residual[first] += pull;
      residual[second] -= pull;
      add(first, first, strength);
      add(second, second, strength);
      add(first, second, -strength);
      add(second, first, -strength);
    }
    for (Eigen::Index i = 0; i < residual.size(); ++i) {
      if (is_held_[i] == 0) continue;
      residual[i] = 0;
      entries.emplace_back(i, i, 1);
    }
    Eigen::SparseMatrix<double> matrix(residual.size(), residual.size());
    matrix.setFromTriplets(entries.begin(), entries.end());
    return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(residual);
  }

  std::unique_ptr<const Scene> scene_;
  std::vector<std::unique_ptr<Force>> forces_;
  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<Vec3> x_;
  std::vector<char> is_held_;
  std::vector<Tie> ties_;
};

}  // namespace weft::sim
