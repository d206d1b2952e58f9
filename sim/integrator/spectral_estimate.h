// How fast the fastest vibration and the fastest decay of a state are.
#pragma once

#include <span>

#include "sim/integrator/dynamics.h"

namespace weft::sim {

struct SpectralEstimate {
  double frequency = 0;  // rad/s: the root of the spectral radius of M^-1 K
  double decay = 0;      // 1/s: the spectral radius of M^-1 D
  int place = -1;        // the particle that takes most part in the faster of the two; -1: none
  // The rate which an explicit method's steps must be short against.
  double stiffest() const { return frequency > decay ? frequency : decay; }
};

// By power iterations on the matrices of the dynamics at (t, y), which it assembles, without
// contact; prescribed particles are held. Within a few percent from below: the radius is approached
// along a series that grows. Cost: an assembly and 60 products a matrix.
SpectralEstimate estimate_spectrum(Dynamics& dynamics, double t, std::span<const double> y);

}  // namespace weft::sim
