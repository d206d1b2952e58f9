// Combines several arrays of one kind of force into a single force with one energy.
#pragma once

#include <memory>
#include <vector>

#include "sim/forces/force.h"

namespace weft::sim {

// Returns the sum of all members as one force. Null members are left out. Returns null if none is
// left, and a single member as it is. Precondition: all members have the same name() and the same
// is_membrane().
std::unique_ptr<Force> grouped(std::vector<std::unique_ptr<Force>> members);

}  // namespace weft::sim
