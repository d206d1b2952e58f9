// Estimates the memory that a scene needs from its numbers of vertices, before anything is
// allocated.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Numbers of vertices, in the order of the case. They are doubles because a resolution may ask for
// more vertices than any integer holds.
struct SceneSize {
  std::vector<double> body, obstacle;
};

// Sizes of all shapes that the case describes; 0 for shapes from files. Precondition: resolutions
// are checked.
SceneSize size_of_case(const Case& source);

// Peak memory of a run, bytes: meshes, states, forces, matrices with their coarse levels, pyramids
// and candidate pairs. The estimate rests on measurements per vertex and is right within a factor
// of two: 2.5 kB for a cvode run without contact and bending, 6 kB with both. It leaves out OpenGL
// contexts and the second run of --estimate-error.
double estimate_memory(const Case& source, const SceneSize& size);

// Index of the shape that takes the most memory; bodies count before obstacles.
std::size_t largest_shape(const Case& source, const SceneSize& size);

// compute.memory_limit in bytes. The default is nine tenths of the machine's memory, or of the
// control group's if that has less.
double memory_limit(const Case& source);
double default_memory_limit();

// Reason to refuse a scene that exceeds the limit: "the scene needs about 570 GiB of memory, more
// than the limit of 21.2 GiB". Empty if it does not.
std::string reason_of_memory(const Case& source, const SceneSize& size);
inline constexpr const char* memory_hint =
    "expected fewer vertices, or a larger compute.memory_limit";

// Formats an amount of memory: "12.25 MiB", "21.2 GiB", "570 GiB".
std::string memory_text(double bytes);

}  // namespace weft::sim
