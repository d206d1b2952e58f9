// Several arrays of one kind of force as a single force, with one energy.
#pragma once

#include <memory>
#include <vector>

#include "sim/forces/force.h"

namespace weft::sim {

// Returns null for no members, a single member as it is, and otherwise a force that is the sum of
// all. Null members are left out; all have the same name and are membranes or not.
std::unique_ptr<Force> grouped(std::vector<std::unique_ptr<Force>> members);

}  // namespace weft::sim
