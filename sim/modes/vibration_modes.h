// Natural modes: small vibrations about an equilibrium.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/base/failure.h"
#include "sim/base/vectors.h"

namespace weft::sim {

class Dynamics;

// A solution x(t) = equilibrium + shape a cos(omega t) of the linearised motion without damping,
// K shape = omega^2 M shape.
struct VibrationMode {
  enum class Kind {
    vibration,
    growth,  // omega^2 < 0: the equilibrium is unstable, and the shape grows as exp(growth_rate t)
    rigid,   // omega^2 = 0 up to rounding: each body moves rigidly
    slack    // omega^2 = 0 up to rounding: nothing resists the shape
  };
  Kind kind = Kind::vibration;
  double eigenvalue = 0;  // omega^2 (1/s^2), as computed
  double modal_mass = 0;  // shape . M shape (kg)
  double error = 0;       // equation_error() of sim/modes/mode_shape.h
  // One displacement per dynamic particle, of which the largest has the length 1. Zero for held
  // particles.
  std::vector<Vec3> shape;

  double angular_frequency() const;  // rad/s; 0 unless kind is `vibration`
  double frequency() const;          // Hz
  double growth_rate() const;        // 1/s; 0 unless kind is `growth`
};

// Returns the kind in words: "vibration", "growth", "rigid", "slack".
const char* kind_name(VibrationMode::Kind kind);

struct VibrationModes {
  std::vector<VibrationMode> modes;  // in ascending order of eigenvalues
  int unknowns = 0;                  // number of coordinates of free particles
  std::optional<Failure> failure;    // if set, there are no modes
};

// Returns the `count` modes with the lowest eigenvalues about `state` at `time` (s), or all modes
// if there are fewer. K is the exact tangent stiffness under the loads set in the dynamics.
// Contacts are springs along their normals, without friction. M is mass_matrix(). Damping is
// ignored.
//
// All copies of a multiple mode are found (largest_eigenpairs.h). Cost: about ten factorisations of
// K.
VibrationModes find_vibration_modes(Dynamics& dynamics, double time, std::span<const double> state,
                                    int count);

}  // namespace weft::sim
