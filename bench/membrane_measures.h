// Forces and moduli of membranes, from the forces and energies of a built case.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/scene/scene.h"
#include "tests/measured_fabrics.h"

namespace weft::bench {

// Returns the forces (N) with which the membrane of the first body pulls at its last column along x
// and at its last row along y.
std::array<double, 2> membrane_pulls(const sim::Scene& scene, std::span<const sim::Vec3> position);

// The pull of a stretched sheet of measured fabric, and that of the published law, evaluated
// without the code of materials/ (tests/measured_fabrics.h).
struct FabricPull {
  std::string stretch;  // in words
  double force = 0, published = 0;
};
// Stretches the sheet of stretched_fabric.toml along its rows, at `degrees` to the warp and with
// its width held: the forces, N.
std::vector<FabricPull> uniaxial_pulls(const sim::Case& sheet, const MeasuredFabric& fabric,
                                       double degrees);
// Stretches it alike along warp and weft: the sums of both forces per width, N/m.
std::vector<FabricPull> biaxial_pulls(const sim::Case& sheet, const MeasuredFabric& fabric);

// Returns the work per area (J/m^2) of the published tensions on the straight path to these Green
// strains along warp and weft, by Simpson's rule.
double published_work(const MeasuredFabric& fabric, double e11, double e22);
// Pulls the sheet of pulled_fabric.toml along its warp or its weft, with free sides: the force, N.
// That of the published law takes the width of the least work, and is the change of that work.
// Throws std::runtime_error if the run fails.
FabricPull free_pull(const sim::Case& sheet, const MeasuredFabric& fabric, bool along_warp,
                     double stretch);

// Plane moduli of a square lattice of springs, N/m.
struct LatticeModuli {
  double c11 = 0, c12 = 0, c66 = 0;

  double stretch_stiffness() const { return (c11 * c11 - c12 * c12) / c11; }  // E h
  double poisson_ratio() const { return c12 / c11; }
};
// Returns the moduli of spring_lattice.toml with n x n cells from its energy per area under small
// strains. The borders cause an error of order 1 / n.
LatticeModuli lattice_moduli(const sim::Case& lattice, int n);
// Returns the moduli of cells of no size, extrapolated from n and n / 2 cells along a side.
LatticeModuli refined_moduli(const sim::Case& lattice, int n);

}  // namespace weft::bench
