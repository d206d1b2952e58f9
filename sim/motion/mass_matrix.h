// The mass matrix of a scene.
#pragma once

#include <Eigen/SparseCore>

namespace weft::sim {

struct Scene;

// Returns the mass matrix (kg) of the dynamic particles, held ones included. It has one number per
// pair of particles, the same along every axis: the kinetic energy is 1/2 sum_ij M_ij v_i . v_j.
// Both triangles are stored.
//
// Shells have their consistent mass, M_ij = integral of density thickness N_i N_j over the rest
// surface, where N are the basis functions of the control points. Its row sums are Scene::mass.
// Cloth has Scene::mass on the diagonal. O(elements); made once for each scene.
Eigen::SparseMatrix<double> mass_matrix(const Scene& scene);

}  // namespace weft::sim
