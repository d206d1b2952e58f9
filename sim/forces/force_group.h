// Combines forces with a common name into a single force.
#pragma once

#include <memory>
#include <vector>

#include "sim/forces/force.h"

namespace weft::sim {

// Returns the sum of all members as one force. Null members are ignored. Returns null if no member
// remains, and the member itself if only one remains. Preconditions: all members have the same
// name() and the same is_membrane(). Members are neither external, nor loads, nor constraints, and
// have no moving points.
std::unique_ptr<Force> grouped(std::vector<std::unique_ptr<Force>> members);

}  // namespace weft::sim
