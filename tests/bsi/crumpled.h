// Positions with noise, for tests of images that are not smooth.
#pragma once

#include <random>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// Moves every component by noise of this standard deviation (m). The result depends only on the
// arguments.
inline std::vector<Vec3> crumpled(std::vector<Vec3> positions, double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, amplitude);
  for (Vec3& position : positions) position += Vec3(noise(random), noise(random), noise(random));
  return positions;
}

}  // namespace weft::bsi
