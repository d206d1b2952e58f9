// The forces that modes leave out.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace weft::sim {

class Dynamics;

// Returns warnings about forces of a case whose linearisation modes do not contain: loads without a
// potential, of whose stiffness only the symmetric part is taken, and wind on bodies with drag.
// `state` is the state at `time` (s) about which modes are computed. Cost: 16 evaluations of the
// loads, if a force turns with the surface.
std::vector<std::string> left_out_forces(Dynamics& dynamics, double time,
                                         std::span<const double> state);

// Returns how far the stiffness L = -dF/dx of the loads F, at their present factor, is from
// symmetric: the root mean square of a.Lb - b.La over random displacements a and b of the free
// particles, divided by that of a.Lb. It is of order 1 for a load on a free edge that turns with
// it, and 0 without loads that turn.
double load_asymmetry(Dynamics& dynamics, double time, std::span<const double> state);

}  // namespace weft::sim
