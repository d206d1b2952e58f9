// The part of the output of `weft check` that describes the trajectory.
#pragma once

#include <iosfwd>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the approximate size on disk (bytes) of a run's images and their views, before
// compression. It leaves out series, records and steps: some hundred bytes per frame and step.
double image_bytes(const Scene& scene);

// Prints the size of the recorded images, their compression and precision, the number of frames,
// the recorded bodies and the channels.
void describe_output(const Scene& scene, std::ostream& out);

}  // namespace weft::sim
