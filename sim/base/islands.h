// Groups of elements that are connected with each other.
#pragma once

#include <vector>

namespace weft::sim {

// Elements and connections between them, with a number for each element that is the same for all
// elements of an island, and for them alone.
class Islands {
 public:
  // Begins with elements without connections.
  void clear(int elements);
  // Connects two elements. O(log n) on average.
  void connect(int one, int other);
  // Returns the number of the island: the lowest index of its elements. O(log n) on average.
  int island_of(int element);

 private:
  std::vector<int> parent_;  // by element: one of its island, itself if it is the lowest
};

}  // namespace weft::sim
