// Groups of spheres that are connected with each other.
#pragma once

#include <vector>

namespace weft::sim {

// Spheres and connections between them, with a number for each sphere that is the same for all
// spheres of an island, and for them alone.
class SphereIslands {
 public:
  // Begins with spheres without connections.
  void clear(int spheres);
  // Connects two spheres. O(log n) on average.
  void connect(int one, int other);
  // Returns the number of the island: the lowest index of its spheres. O(log n) on average.
  int island_of(int sphere);

 private:
  std::vector<int> parent_;  // by sphere: a sphere of its island, itself if it is the lowest
};

}  // namespace weft::sim
