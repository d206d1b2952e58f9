// Estimates the memory of a scene from its numbers of vertices, before anything is allocated.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Numbers of vertices by shape, in the order of the case. They are doubles because a resolution may
// ask for more vertices than an integer can hold.
struct SceneSize {
  std::vector<double> body, obstacle;
};

// Returns the sizes of all shapes of the case; 0 for shapes from files. Precondition: resolutions
// are checked.
SceneSize size_of_case(const Case& source);

// Returns the peak memory of a run (bytes): meshes, states, forces, matrices with their coarse
// levels, pyramids and candidate pairs. The estimate is based on measurements per vertex and
// correct within a factor of two. A cvode run takes 2.5 kB per vertex without contact and bending,
// 6 kB with both. OpenGL contexts and the second run of --estimate-error are not included.
double estimate_memory(const Case& source, const SceneSize& size);

// Returns the index of the shape that needs the most memory. Bodies count before obstacles.
std::size_t largest_shape(const Case& source, const SceneSize& size);

// memory_limit() returns compute.memory_limit or its default (bytes). default_memory_limit()
// returns nine tenths of the memory of the machine or, if less, of its control group.
double memory_limit(const Case& source);
double default_memory_limit();

// Returns a reason to refuse a scene that exceeds the limit: "the scene needs about 570 GiB of
// memory, more than the limit of 21.2 GiB". Empty for other scenes.
std::string reason_of_memory(const Case& source, const SceneSize& size);
inline constexpr const char* memory_hint =
    "expected fewer vertices, or a larger compute.memory_limit";

// Returns an amount of memory as text: "12.25 MiB", "21.2 GiB", "570 GiB".
std::string memory_text(double bytes);

}  // namespace weft::sim
