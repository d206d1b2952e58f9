#include "sim/base/islands.h"

#include <algorithm>
#include <numeric>

namespace weft::sim {

void Islands::clear(int elements) {
  parent_.resize(static_cast<std::size_t>(elements));
  std::iota(parent_.begin(), parent_.end(), 0);
}

int Islands::island_of(int element) {
  while (parent_[element] != element) {
    parent_[element] = parent_[parent_[element]];
    element = parent_[element];
  }
  return element;
}

void Islands::connect(int one, int other) {
  const auto [low, high] = std::minmax({island_of(one), island_of(other)});
  parent_[high] = low;
}

}  // namespace weft::sim
