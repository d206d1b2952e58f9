// Pairs of scenes of which the second has what the first does not need.
#pragma once

#include <string>
#include <vector>

namespace weft::bench {

struct SkippingPair {
  std::string name;
  std::string meaning;
  std::string without, with;    // cases
  double bar = 0;               // the ratio of the CPU times to stay below; 0: none
  bool same_trajectory = true;  // the first body must move the same in both, to the bit
};

std::vector<SkippingPair> skipping_pairs();

}  // namespace weft::bench
