// The mass matrix of a scene.
#pragma once

#include <Eigen/SparseCore>

namespace weft::sim {

struct Scene;

// Returns the mass matrix (kg) of the dynamic particles, held ones included. One number per pair of
// particles holds for all three axes: the kinetic energy is 1/2 sum_ij M_ij v_i . v_j. Both
// triangles are stored.
//
// Shells have their consistent mass: M_ij is the integral of density * thickness * N_i N_j over the
// rest surface, where N_i is the basis function of control point i. Its row sums are Scene::mass.
// Cloth has Scene::mass on the diagonal. Cost: O(elements).
Eigen::SparseMatrix<double> mass_matrix(const Scene& scene);

}  // namespace weft::sim
