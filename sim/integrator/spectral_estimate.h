// How fast the fastest vibration and the fastest decay of a state are.
#pragma once

#include <span>
#include <vector>

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
// along a series that grows. Cost: an assembly and 30 products a matrix.
SpectralEstimate estimate_spectrum(Dynamics& dynamics, double t, std::span<const double> y);

// The fastest vibration of a motion, followed as it goes on: an iteration of the power method now
// and then, from the last one's vector, by a difference of accelerations. For scenes without
// contact.
class FrequencyTracker {
 public:
  // At the state y, by a third as many iterations as above.
  FrequencyTracker(Dynamics& dynamics, double t, std::span<const double> y);

  // At the state y, whose accelerations these are. Cost: an evaluation of the forces.
  void follow(double t, std::span<const double> y, std::span<const Vec3> acceleration);
  // From now on follows what these accelerations have most of.
  void turn_to(std::span<const Vec3> acceleration);
  double frequency() const { return frequency_; }  // rad/s, from below
  int place() const;                               // the particle that vibrates most

 private:
  Dynamics& dynamics_;
  double amplitude_ = 0;         // m, of the differences
  std::vector<Vec3> vibration_;  // the largest entry is 1
  std::vector<double> moved_;    // a state
  std::vector<Vec3> change_;     // m/s^2
  double frequency_ = 0;
};

}  // namespace weft::sim
