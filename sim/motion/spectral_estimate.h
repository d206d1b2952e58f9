// Estimates of the fastest vibration and the fastest decay of a state.
#pragma once

#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

struct SpectralEstimate {
  double frequency = 0;  // square root of the spectral radius of M^-1 K (rad/s)
  double decay = 0;      // spectral radius of M^-1 D (1/s)
  int place = -1;        // particle that moves most in the mode of stiffest(); -1: none
  // Returns the rate (1/s) that limits the steps of an explicit method.
  double stiffest() const { return frequency > decay ? frequency : decay; }
};

// Estimates the spectrum at (t, y), without contact, by power iterations on the matrices K and D,
// which it assembles. Prescribed particles are held. Estimates are below the true values by up to a
// few percent. Cost: an assembly, and 30 products per matrix.
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
  // Continues with the vibration that dominates these accelerations.
  void track_direction_of(std::span<const Vec3> acceleration);
  // Writes or reads all data that determine the bits of later frequencies.
  void transfer(StateArchive& archive) { archive(amplitude_, vibration_, frequency_); }
  double frequency() const { return frequency_; }  // rad/s, estimated from below
  int place() const;                               // particle that vibrates most

 private:
  Dynamics& dynamics_;
  double amplitude_ = 0;  // largest displacement (m) of the finite differences
  // Shape of the vibration. Each iteration scales its largest coordinate to 1 or -1.
  std::vector<Vec3> vibration_;
  std::vector<double> moved_;  // scratch: a displaced state
  std::vector<Vec3> change_;   // scratch: accelerations (m/s^2)
  double frequency_ = 0;
};

}  // namespace weft::sim
