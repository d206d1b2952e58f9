#include "sim/motion/mass_matrix.h"

#include <Eigen/Core>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/shell_body.h"

namespace weft::sim {

namespace {

using Entries = std::vector<Eigen::Triplet<double>>;

// Sums the mass matrix of one shell element at a time over its quadrature points.
class ElementMass {
 public:
  explicit ElementMass(int first_particle) : first_particle_(first_particle) {}

  void add(const SplineSurface::Point& point, double mass) {
    nodes_ = point.control_points;
    const Eigen::Map<const Eigen::VectorXd> value(point.value.data(), std::ssize(point.value));
    if (sum_.size() == 0) sum_.setZero(value.size(), value.size());
    sum_ += mass * value * value.transpose();
  }
  // Appends the sum to `entries` and resets it for the next element.
  void finish(Entries& entries) {
    for (Eigen::Index i = 0; i < sum_.rows(); ++i) {
      for (Eigen::Index j = 0; j < sum_.cols(); ++j)
        entries.emplace_back(first_particle_ + nodes_[i], first_particle_ + nodes_[j], sum_(i, j));
    }
    sum_.setZero();
  }
  bool is_of(const std::vector<int>& nodes) const { return nodes_ == nodes; }

 private:
  int first_particle_;
  std::vector<int> nodes_;
  Eigen::MatrixXd sum_;
};

void add_shell(const SceneBody& body, Entries& entries) {
  ElementMass element(body.first_particle);
  visit_shell_mass(body, [&](const SplineSurface::Place& /*place*/,
                             const SplineSurface::Point& point, double mass) {
    if (!element.is_of(point.control_points)) element.finish(entries);
    element.add(point, mass);
  });
  element.finish(entries);
}

}  // namespace

Eigen::SparseMatrix<double> mass_matrix(const Scene& scene) {
  Eigen::SparseMatrix<double> sum(scene.dynamic_particles, scene.dynamic_particles);
  Entries entries;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    if (body.spline) {
      add_shell(body, entries);
      continue;
    }
    for (int i = 0; i < body.particle_count(); ++i) {
      const int particle = body.first_particle + i;
      entries.emplace_back(particle, particle, scene.mass[particle]);
    }
  }
  sum.setFromTriplets(entries.begin(), entries.end());
  return sum;
}

}  // namespace weft::sim
