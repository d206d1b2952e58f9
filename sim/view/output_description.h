// The part of `weft check` about the trajectory.
#pragma once

#include <iosfwd>

#include "sim/scene/scene.h"

namespace weft::sim {

// Bytes that the images of a run take on the disk with their views, before compression. Series,
// records and steps come on top, some hundred bytes for each frame and step.
double image_bytes(const Scene& scene);

// Prints how many frames are recorded, of which bodies and fields, how they are stored, how much
// disk space that takes, and what is skipped.
void describe_output(const Scene& scene, std::ostream& out);

}  // namespace weft::sim
