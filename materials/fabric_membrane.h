// The membrane of a triangle of cloth with any elastic law (strain_map.h) over the strain
// e = (E_11, E_22, 2 E_12) (orthotropic_membrane.h). The edge tensions are
//   s = A B^T (dw/de + beta V B q'),
// with the rest area A, the changes q of the squared edge lengths, and e = B q. The second term is
// Kelvin-Voigt damping. V are the semi-definite moduli of the law.
#pragma once

#include "materials/membrane.h"
#include "materials/strain_map.h"

namespace weft::materials {

template <class Real>
struct FabricMembraneOf {
  std::array<Real, 3> rest_squared_length{};  // L_i^2 of the edge opposite node i, m^2
  StrainMapOf<Real> strains;                  // map from q to e
  Real damping_time = 0;                      // beta, s
};
using FabricMembrane = FabricMembraneOf<double>;

// Makes the membrane of a triangle. `rest` holds the positions of the nodes (m) as columns,
// `damping_time` is beta (s). The projection of `warp` onto the triangle is the axis of the warp.
// Preconditions: the rest triangle has an area, and `warp` is not normal to it.
FabricMembrane make_fabric_membrane(const Nodes3& rest, const Vec3& warp, double damping_time);

// Returns the energy (J). x holds the positions of the nodes (m) as columns.
template <class Real, class Law>
Real fabric_energy(const FabricMembraneOf<Real>& membrane, const Law& law,
                   const NodesOf<Real, 3>& x) {
  return law_energy(membrane.strains, law, squared_length_changes(membrane, opposite_edges(x)));
}

// Return the edge tensions s, N/m. The first overload omits the damping. `edges` is the result of
// opposite_edges() (m), and `v` holds the velocities of the nodes (m/s) as columns. pulls_of()
// (membrane.h) converts tensions to forces.
template <class Real, class Law>
Vec3Of<Real> fabric_tensions(const FabricMembraneOf<Real>& membrane, const Law& law,
                             const NodesOf<Real, 3>& edges) {
  return law_slope(membrane.strains, law, squared_length_changes(membrane, edges));
}
template <class Real, class Law>
Vec3Of<Real> fabric_tensions(const FabricMembraneOf<Real>& membrane, const Law& law,
                             const NodesOf<Real, 3>& edges, const NodesOf<Real, 3>& v) {
  const Vec3Of<Real> q = squared_length_changes(membrane, edges);
  const Vec3Of<Real> rates = membrane.damping_time * squared_length_rates(edges, v);
  return law_slope(membrane.strains, law, q) + law_viscosity(membrane.strains, law, q) * rates;
}

// A symmetric 3 x 3 matrix over the edges of a triangle, N/m^3. It serves as the `Membrane` of
// functions in membrane.h that use only modulus() and times_modulus().
template <class Real>
struct EdgeModulusOf {
  Symmetric3Of<Real> entries;

  const Real& modulus(int i, int j) const { return entries(i, j); }
  Vec3Of<Real> times_modulus(const Vec3Of<Real>& q) const { return entries * q; }
};

}  // namespace weft::materials
