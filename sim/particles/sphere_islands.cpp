#include "sim/particles/sphere_islands.h"

#include <algorithm>
#include <numeric>

namespace weft::sim {

void SphereIslands::clear(int spheres) {
  parent_.resize(static_cast<std::size_t>(spheres));
  std::iota(parent_.begin(), parent_.end(), 0);
}

int SphereIslands::island_of(int sphere) {
  while (parent_[sphere] != sphere) {
    parent_[sphere] = parent_[parent_[sphere]];
    sphere = parent_[sphere];
  }
  return sphere;
}

void SphereIslands::connect(int one, int other) {
  const auto [low, high] = std::minmax({island_of(one), island_of(other)});
  parent_[high] = low;
}

}  // namespace weft::sim
