// The text of `weft check`.
#pragma once

#include <string>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the text of `weft check`: what the scene needs, which computations it skips, and why.
std::string describe_scene(const Scene& scene);

}  // namespace weft::sim
