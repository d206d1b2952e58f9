// A random, stationary fluctuation of wind speed.
#pragma once

#include <vector>

#include "sim/case/varying.h"

namespace weft::sim {

// The longitudinal turbulence of Dryden (MIL-HDBK-1797, appendix A): the speed along the mean wind
// has the one-sided spectrum
//
//   S(w) = sigma^2 (2 T / pi) / (1 + (w T)^2),
//
// with its standard deviation sigma and its integral time scale T. Its autocorrelation is that of
// an Ornstein-Uhlenbeck process, sigma^2 exp(-|t| / T). A sum of cosines with random phases
// represents it (M. Shinozuka, G. Deodatis: Simulation of stochastic processes by spectral
// representation, Applied Mechanics Reviews 44, 1991). The spectrum is cut into `waves` bands of
// equal energy, and each band's cosine lies at its median, w_k = tan(pi/2 (k + 1/2) / waves) / T.
// All amplitudes are then sigma sqrt(2 / waves): the variance is exact, and the speed is smooth in
// time. The generator of the phases is fixed, so a seed names the same gust everywhere.
class Gust {
 public:
  static constexpr int waves = 64;

  explicit Gust(const GustCase& source);

  // Velocity (m/s) at a time (s). Cost: a cosine per wave.
  Vec3 at(double time) const;
  // Longest step (s) that follows the fastest wave: a quarter of its period, 0.019 T.
  double longest_step() const;

 private:
  struct Wave {
    double frequency;  // rad/s
    double phase;      // rad
  };
  Vec3 mean_;
  double amplitude_;  // as a fraction of the mean
  std::vector<Wave> waves_;
};

}  // namespace weft::sim
