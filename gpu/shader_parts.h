// Pieces of GLSL that several compute shaders share. Private to gpu/.
#pragma once

#include <string>

namespace weft::gpu::shaders {

// Returns GLSL text for a number, exact to the bit.
std::string exactly(float value);
std::string exactly(double value);

// GLSL declarations of buffers, with the functions that read them. `vertices` must follow `levels`.
extern const char* const levels;    // table of levels
extern const char* const vertices;  // vertices, and the map of texels to particles
extern const char* const boxes;     // boxes and spheres of blocks
extern const char* const tangents;  // bounds of the steps between vertices

}  // namespace weft::gpu::shaders
