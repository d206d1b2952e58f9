// Estimates of the fastest vibration and the fastest decay of a state.
#pragma once

#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

struct SpectralEstimate {
  double frequency = 0;  // rad/s: the square root of the spectral radius of M^-1 K
  double decay = 0;      // 1/s: the spectral radius of M^-1 D
  int place = -1;        // the particle that moves most in the mode of stiffest(); -1: none
  // Returns the rate (1/s) that limits the steps of an explicit method.
  double stiffest() const { return frequency > decay ? frequency : decay; }
};

// Estimates the spectrum at (t, y) by power iterations on the matrices of the dynamics, which it
// assembles without contact. Prescribed particles are held. Estimates are below the true values by
// up to a few percent. Cost: an assembly, and 30 products per matrix.
SpectralEstimate estimate_spectrum(Dynamics& dynamics, double t, std::span<const double> y);

// Tracks the fastest vibration of a motion. Each call of follow() is one power iteration, whose
// matrix product is a finite difference of accelerations. Precondition: the scene has no contact.
class FrequencyTracker {
 public:
  // Starts at the state y with 10 iterations, a third of those of estimate_spectrum(). Cost: 11
  // evaluations of the forces.
  FrequencyTracker(Dynamics& dynamics, double t, std::span<const double> y);

  // Does one iteration at the state y, whose accelerations (m/s^2) are given. Cost: one evaluation
  // of the forces.
  void follow(double t, std::span<const double> y, std::span<const Vec3> acceleration);
  // From now on, tracks the vibration that dominates these accelerations.
  void track_direction_of(std::span<const Vec3> acceleration);
  // Writes or reads everything on which the bits of later frequencies depend.
  void transfer(StateArchive& archive) { archive(amplitude_, vibration_, frequency_); }
  double frequency() const { return frequency_; }  // rad/s, a lower estimate
  int place() const;                               // the particle that vibrates most

 private:
  Dynamics& dynamics_;
  double amplitude_ = 0;         // m, displacement of the finite differences
  std::vector<Vec3> vibration_;  // the largest entry is 1
  std::vector<double> moved_;    // scratch: a state
  std::vector<Vec3> change_;     // m/s^2
  double frequency_ = 0;
};

}  // namespace weft::sim
