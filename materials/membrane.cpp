#include "materials/membrane.h"

#include <cassert>
#include <cmath>

namespace weft::materials {

namespace {

// sum_ij D_ia M_ij D_jb for M_ij = 4 C_ij e_i e_j^T + 2 s_i delta_ij I: a Hessian in the edges
// carried to the nodes. D is the signed incidence: node a ends edge a + 1 and starts edge a + 2.
Mat9 from_edges_to_nodes(const Mat3& modulus, const Nodes3& edges, const Vec3& tensions) {
  std::array<std::array<Mat3, 3>, 3> blocks;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      blocks[i][j] = (4 * modulus(i, j) * edges.col(i)) * edges.col(j).transpose();
      if (i == j) {
        blocks[i][i].diagonal().array() += 2 * tensions[i];
      } else {
        blocks[j][i] = blocks[i][j].transpose();
      }
    }
  }
  Mat9 result;
  for (int a = 0; a < 3; ++a) {
    const int a_end = (a + 1) % 3;
    const int a_start = (a + 2) % 3;
    for (int b = 0; b < 3; ++b) {
      const int b_end = (b + 1) % 3;
      const int b_start = (b + 2) % 3;
      result.block<3, 3>(3 * a, 3 * b) = blocks[a_end][b_end] - blocks[a_end][b_start] -
                                         blocks[a_start][b_end] + blocks[a_start][b_start];
    }
  }
  return result;
}

}  // namespace

TriangleMembrane make_triangle_membrane(const Nodes3& rest, double stiffness, double poisson_ratio,
                                        double damping_time) {
  assert(poisson_ratio > -1 && poisson_ratio < 1);
  const Nodes3 edges = opposite_edges(rest);
  const double double_area = edges.col(0).cross(edges.col(1)).norm();
  assert(double_area > 0);
  // Delingette 2008 writes mu for twice the shear modulus of the usual Lame pair.
  const double plane_stress = stiffness / (1 - poisson_ratio * poisson_ratio);
  const double lambda = plane_stress * poisson_ratio;
  const double mu = plane_stress * (1 - poisson_ratio);
  TriangleMembrane membrane;
  membrane.damping_time = damping_time;
  Vec3 cotangents;
  for (int i = 0; i < 3; ++i) {
    membrane.rest_squared_length[i] = edges.col(i).squaredNorm();
    cotangents[i] = -edges.col((i + 1) % 3).dot(edges.col((i + 2) % 3)) / double_area;
  }
  // k_i / 2 on the diagonal, c_ij / 2 beside it.
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double sign = i == j ? 1 : -1;
      membrane.modulus(i, j) =
          (2 * cotangents[i] * cotangents[j] * (lambda + mu) + sign * mu) / (16 * double_area);
    }
  }
  return membrane;
}

Mat9 membrane_stiffness(const TriangleMembrane& membrane, const Nodes3& x, const Nodes3& v) {
  const Nodes3 edges = opposite_edges(x);
  return from_edges_to_nodes(membrane.modulus, edges, edge_tensions(membrane, edges, v));
}

Mat9 membrane_damping(const TriangleMembrane& membrane, const Nodes3& x) {
  return from_edges_to_nodes(membrane.damping_time * membrane.modulus, opposite_edges(x),
                             Vec3::Zero());
}

}  // namespace weft::materials
