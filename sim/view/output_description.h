// The part of the text of `weft check` that is about the trajectory.
#pragma once

#include <iosfwd>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the size on disk of a run's images and their views, before compression (bytes). Series,
// records and steps take some hundred bytes more per frame and step.
double image_bytes(const Scene& scene);

// Prints the number of recorded frames, the recorded bodies and fields, the storage and its disk
// space, and what is skipped.
void describe_output(const Scene& scene, std::ostream& out);

}  // namespace weft::sim
