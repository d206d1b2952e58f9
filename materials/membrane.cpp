#include "materials/membrane.h"

#include <cassert>
#include <cmath>

namespace weft::materials {

TriangleMembrane make_triangle_membrane(const Nodes3& rest, double stiffness, double poisson_ratio,
                                        double damping_time) {
  assert(poisson_ratio > -1 && poisson_ratio < 1);
  const Nodes3 edges = opposite_edges(rest);
  const double double_area = edges.col(0).cross(edges.col(1)).norm();
  assert(double_area > 0);
  // In Delingette 2008, mu is twice the shear modulus of the usual Lame pair.
  const double plane_stress = stiffness / (1 - poisson_ratio * poisson_ratio);
  const double lambda = plane_stress * poisson_ratio;
  const double mu = plane_stress * (1 - poisson_ratio);
  TriangleMembrane membrane;
  membrane.damping_time = damping_time;
  // C_ij = [2 (lambda + mu) cot_i cot_j + mu s_ij] / (16 double_area), where s_ij is 1 for i = j
  // and -1 otherwise. In membrane.h, k_i = 2 C_ii and c_ij = 2 C_ij.
  membrane.shear = mu / (16 * double_area);
  const double scale = std::sqrt(2 * (lambda + mu) / (16 * double_area));
  for (int i = 0; i < 3; ++i) {
    membrane.rest_squared_length[i] = edges.col(i).squaredNorm();
    membrane.root[i] = -scale * dot(edges.col((i + 1) % 3), edges.col((i + 2) % 3)) / double_area;
  }
  return membrane;
}

}  // namespace weft::materials
