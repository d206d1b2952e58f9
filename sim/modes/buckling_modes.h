// Linear buckling: the multiples of a load at which an equilibrium becomes unstable.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/base/failure.h"
#include "sim/base/vectors.h"

namespace weft::sim {

class Dynamics;
struct Case;

// Throws CaseError, placed at the first body or load, if nothing loads the case whose multiples
// could be critical: it has neither a [[load]] that is not zero, nor gravity with
// static.scale_gravity.
void require_load(const Case& source);

struct BucklingMode {
  double load_factor = 0;  // critical; negative: of the reversed load
  double error = 0;        // of the equation (sim/modes/mode_shape.h)
  // Displacements by dynamic particle, in multiples of the largest; zero where held.
  std::vector<Vec3> shape;
};

struct BucklingModes {
  std::vector<BucklingMode> modes;  // by rising distance of their factors from that of the state
  int unknowns = 0;                 // coordinates of free particles
  std::optional<Failure> failure;   // there are no modes then
};

// Returns the `count` modes whose load factors are nearest to that of an equilibrium, or fewer if
// the loads stress it in fewer ways. At the state, under `load_factor` times the loads (each
// [[load]], and gravity with static.scale_gravity), K is the tangent stiffness, K u = load the
// linear response to one more load, and G the rate at which K changes along it:
//   (K + (critical - load_factor) G) shape = 0,  G = d/ds K(x + s u, load_factor + s) at s = 0,
// by central differences, which are exact for membranes. G has the geometric stiffness of the
// linear stresses, and the load's own stiffness where it turns with the surface.
//
// Fails if K is singular or has negative directions, and if the loads move nothing. Costs three
// assemblies of K, three factorisations or more, and some ten solutions per mode.
BucklingModes find_buckling_modes(Dynamics& dynamics, double time, std::span<const double> state,
                                  double load_factor, int count);

}  // namespace weft::sim
