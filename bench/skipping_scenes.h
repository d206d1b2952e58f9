// Pairs of scenes; the second has features that the first does not need.
#pragma once

#include <string>
#include <vector>

namespace weft::bench {

struct SkippingPair {
  std::string name;
  std::string meaning;
  std::string without, with;    // cases
  double bar = 0;               // largest allowed ratio of the CPU times; 0: none
  bool same_trajectory = true;  // the first body must move identically in both
};

std::vector<SkippingPair> skipping_pairs();

}  // namespace weft::bench
