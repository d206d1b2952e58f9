#include "sim/scene/gust.h"

#include <cmath>
#include <numbers>
#include <random>

namespace weft::sim {

Gust::Gust(const GustCase& source)
    : mean_(source.mean), amplitude_(source.intensity * std::sqrt(2.0 / waves)) {
  // The C++ standard fixes the numbers of this generator. It does not fix those of the library's
  // distributions, which are not used here.
  std::mt19937_64 random(static_cast<std::uint64_t>(source.seed));
  for (int k = 0; k < waves; ++k) {
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    waves_.push_back({std::tan(std::numbers::pi / 2 * (k + 0.5) / waves) / source.time_scale,
                      2 * std::numbers::pi * share});
  }
}

Vec3 Gust::at(double time) const {
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::cos(wave.frequency * time + wave.phase);
  return (1 + amplitude_ * sum) * mean_;
}

double Gust::longest_step() const { return std::numbers::pi / 2 / waves_.back().frequency; }

}  // namespace weft::sim
