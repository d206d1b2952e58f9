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

// Throws CaseError, placed at the first load or body, if the case has no load to scale: neither a
// nonzero [[load]], nor nonzero gravity with static.scale_gravity. Also throws it for particles.
void require_load(const Case& source);

struct BucklingMode {
  double load_factor = 0;  // critical load factor; negative if the reversed load is critical
  double error = 0;        // equation_error() of sim/modes/mode_shape.h
  // One displacement per dynamic particle, of which the largest has the length 1. Zero for held
  // particles.
  std::vector<Vec3> shape;
};

struct BucklingModes {
  std::vector<BucklingMode> modes;  // in ascending order of |load_factor - factor of the state|
  int unknowns = 0;                 // number of coordinates of free particles
  std::optional<Failure> failure;   // if set, there are no modes
};

// Returns the `count` modes whose critical load factors are nearest to `load_factor`, or all modes
// if there are fewer. `state` is an equilibrium under `load_factor` times the loads: each [[load]],
// and gravity with static.scale_gravity. K is its tangent stiffness, and u with K u = load is the
// linear response to the loads at factor 1. G is the derivative of K along u:
//   (K + (critical - load_factor) G) shape = 0,  G = d/ds K(x + s u, load_factor + s) at s = 0.
// Central differences compute G. They are exact up to rounding for membranes of triangles whose
// tension is linear in the Green strain. G contains the geometric stiffness of the linear stresses.
// It also contains the stiffness of loads whose direction rotates with the surface.
//
// Fails if all particles are held, forces cannot be evaluated, or K is not positive definite. Also
// fails if the loads cause no displacement or no stress, or if the search for eigenvalues does not
// converge. Cost: three assemblies of K, three or more factorisations, and about ten solves per
// mode.
BucklingModes find_buckling_modes(Dynamics& dynamics, double time, std::span<const double> state,
                                  double load_factor, int count);

}  // namespace weft::sim
