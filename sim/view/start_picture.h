// A picture of the initial state of a scene.
#pragma once

#include <span>
#include <string>

#include "sim/scene/scene.h"
#include "sim/view/crossings.h"

namespace weft::sim {

// Writes a PNG of all bodies and particles at t = 0: from above on the left, and from below on the
// right. Red are the triangles of `crossings` and, with contact, the particles that overlap another
// one or a surface. The camera shows the surroundings of what is red, at least a third of the size
// of all simulated bodies; without red, all of these. Surfaces of `crossings` are numbered as
// Scene::bodies. Returns the number of red particles.
//
// A file that no drawing of Weft made is overwritten only with `force`. Throws FileError if it must
// not be overwritten or cannot be written, and if Weft was built without gpu/. Takes tens of
// milliseconds.
int draw_start(const Scene& scene, std::span<const Crossing> crossings, const std::string& path,
               bool force);

}  // namespace weft::sim
