#include "bench/triangle_springs.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <random>

#include "materials/membrane.h"

namespace weft::bench {

namespace {

using materials::Nodes3;
using Vec3 = Eigen::Vector3d;

constexpr double stiffness = 3;  // E h, N/m

Nodes3 random_nodes(std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  return Nodes3::NullaryExpr([&](Eigen::Index, Eigen::Index) { return uniform(generator); });
}

// Triangles close to needles are left out: the Green strain of a needle is rounded too much.
Nodes3 random_rest(std::mt19937& generator) {
  for (;;) {
    Nodes3 rest = random_nodes(generator);
    const Nodes3 edges = materials::opposite_edges(rest);
    const double double_area = edges.col(0).cross(edges.col(1)).norm();
    if (double_area > 0.2 * edges.colwise().squaredNorm().maxCoeff() && double_area > 0.1)
      return rest;
  }
}

// The energy from E = (F^T F - I) / 2: A E h / (2 (1 - nu^2)) ((1 - nu) |E|^2 + nu tr(E)^2).
double energy_from_green_strain(const Nodes3& rest, const Nodes3& x, double poisson_ratio) {
  const Vec3 first = (rest.col(1) - rest.col(0)).normalized();
  const Vec3 normal = first.cross(Vec3(rest.col(2) - rest.col(0))).normalized();
  Eigen::Matrix<double, 3, 2> frame, rest_sides, sides;
  frame << first, normal.cross(first);
  rest_sides << rest.col(1) - rest.col(0), rest.col(2) - rest.col(0);
  sides << x.col(1) - x.col(0), x.col(2) - x.col(0);
  const Eigen::Matrix2d rest_in_plane = frame.transpose() * rest_sides;
  const Eigen::Matrix<double, 3, 2> deformation = sides * rest_in_plane.inverse();
  const Eigen::Matrix2d strain =
      0.5 * (deformation.transpose() * deformation - Eigen::Matrix2d::Identity());
  const double area = 0.5 * std::abs(rest_in_plane.determinant());
  const double trace = strain.trace();
  return 0.5 * area * stiffness / (1 - poisson_ratio * poisson_ratio) *
         ((1 - poisson_ratio) * strain.squaredNorm() + poisson_ratio * trace * trace);
}

}  // namespace

std::vector<TriangleEnergies> random_triangle_energies(int count) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> poisson(-0.95, 0.95);
  std::vector<TriangleEnergies> all;
  for (int i = 0; i < count; ++i) {
    const Nodes3 rest = random_rest(generator), x = random_nodes(generator);
    const double poisson_ratio = poisson(generator);
    const auto springs = materials::make_triangle_membrane(rest, stiffness, poisson_ratio, 0);
    all.push_back(
        {materials::membrane_energy(springs, x), energy_from_green_strain(rest, x, poisson_ratio)});
  }
  return all;
}

}  // namespace weft::bench
