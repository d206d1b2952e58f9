// weft-bench-LIBRARY < settings and problem > outcome
#include <exception>
#include <iostream>

#include "bench/peers/cloth_peer.h"

int main() {
  using namespace weft::bench;
  ClothSettings settings;
  ClothProblem problem;
  if (!(std::cin >> settings >> problem)) {
    std::cerr << "a part of weft bench accuracy, which tells it what to simulate\n";
    return 2;
  }
  try {
    std::cout << simulate_cloth(problem, settings);
  } catch (const std::exception& failure) {
    std::cout << ClothOutcome{failure.what(), 0, {}};
  }
  return 0;
}
