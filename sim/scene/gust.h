// A random, stationary fluctuation of wind speed.
#pragma once

#include <vector>

#include "sim/case/varying.h"

namespace weft::sim {

// The longitudinal turbulence of Dryden (MIL-HDBK-1797, appendix A). The speed along the mean wind
// has the one-sided spectrum
//
//   S(w) = sigma^2 (2 T / pi) / (1 + (w T)^2),
//
// where sigma is the standard deviation of the speed and T its integral time scale. The
// autocorrelation is that of an Ornstein-Uhlenbeck process, sigma^2 exp(-|t| / T).
//
// The speed is a sum of cosines with random phases (M. Shinozuka, G. Deodatis: Simulation of
// stochastic processes by spectral representation, Applied Mechanics Reviews 44, 1991). The
// spectrum is cut into `waves` bands of equal energy. Each band has one cosine at its median, w_k =
// tan(pi/2 (k + 1/2) / waves) / T, with the amplitude sigma sqrt(2 / waves). The variance is
// therefore exact, and the speed is smooth in time. The generator of the phases is fixed, so a seed
// gives the same gust, up to rounding, on every machine.
class Gust {
 public:
  static constexpr int waves = 64;

  explicit Gust(const GustCase& source);

  // Returns the wind velocity (m/s) at a time (s). Cost: a cosine per wave.
  Vec3 at(double time) const;
  // Returns the longest step (s) that resolves the fastest wave: a quarter of its period, 0.019 T.
  double longest_step() const;

 private:
  struct Wave {
    double frequency;  // rad/s
    double phase;      // rad
  };
  Vec3 mean_;
  double amplitude_;  // amplitude of each wave, as a fraction of the mean speed
  std::vector<Wave> waves_;
};

}  // namespace weft::sim
