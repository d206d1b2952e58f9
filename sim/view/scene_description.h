// The text of `weft check`.
#pragma once

#include <string>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the text about what the scene needs, what it skips and why.
std::string describe_scene(const Scene& scene);

}  // namespace weft::sim
