// Memory that a scene needs, from its numbers of vertices, before any of it is taken.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Numbers of vertices, in the order of the case. Doubles, since a resolution may ask for more than
// any integer holds.
struct SceneSize {
  std::vector<double> body, obstacle;
};

// Sizes that the case tells by itself; 0 for a shape from a file. Resolutions are checked already.
SceneSize size_of_case(const Case& source);

// Bytes that a run needs at its height: meshes, states, forces, matrices with their coarse levels,
// pyramids and candidates. By measurements per vertex, within a factor of two: 2.5 kB for a cvode
// run without contact and bending, 6 kB with both. --estimate-error runs the scene twice, and
// contexts of OpenGL come on top.
double estimate_memory(const Case& source, const SceneSize& size);

// Index of the shape that takes most of it, bodies before obstacles.
std::size_t largest_shape(const Case& source, const SceneSize& size);

// compute.memory_limit in bytes; nine tenths of the machine's memory by default, or of the control
// group's where that has less.
double memory_limit(const Case& source);
double default_memory_limit();

// "the scene needs about 570 GiB of memory, more than the limit of 21.2 GiB", or empty where it
// does not.
std::string reason_of_memory(const Case& source, const SceneSize& size);
inline constexpr const char* memory_hint =
    "expected fewer vertices, or a larger compute.memory_limit";

// "12.25 MiB", "21.2 GiB", "570 GiB".
std::string memory_text(double bytes);

}  // namespace weft::sim
