// Triangle springs against the St. Venant-Kirchhoff membrane that they should be.
#pragma once

#include <vector>

namespace weft::bench {

// The energies (J) of a deformed triangle.
struct TriangleEnergies {
  double springs = 0;       // by squared lengths of edges (materials/membrane.h)
  double green_strain = 0;  // by the Green strain in the plane of the rest triangle
};

// Returns the energies of random triangles with random Poisson's ratios, the same in every run.
std::vector<TriangleEnergies> random_triangle_energies(int count);

}  // namespace weft::bench
