// Pieces of GLSL that several compute shaders share. Private to gpu/.
#pragma once

#include <string>

namespace weft::gpu::shaders {

// Returns GLSL text for a number, exact to the bit.
std::string exactly(float value);
std::string exactly(double value);

// Declarations of buffers, with functions that read them: the table of levels, vertices (which need
// the levels), boxes with spheres, and bounds of steps.
extern const char* const levels;
extern const char* const vertices;
extern const char* const boxes;
extern const char* const tangents;

}  // namespace weft::gpu::shaders
