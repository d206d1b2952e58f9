// The output of `weft check`.
#pragma once

#include <string>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the output of `weft check`: the contents of the scene, the resources that it needs, and
// the computations that it skips, with reasons.
std::string describe_scene(const Scene& scene);

}  // namespace weft::sim
