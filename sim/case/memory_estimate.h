// Estimates the memory of a scene from its numbers of vertices, before anything is allocated.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The number of vertices of each body and obstacle, and the number of each group of particles, in
// the order of the case. The numbers are doubles because a resolution may ask for more vertices
// than an integer can hold.
struct SceneSize {
  std::vector<double> body, obstacle, particles;
};

// Returns the size of every body, obstacle and group of particles, or 0 if it comes from a file.
// Precondition: check_shape() accepts the shapes.
SceneSize size_of_case(const Case& source);

// Returns the estimated peak memory of a run (bytes), correct within a factor of two. It comprises
// meshes, states, forces, matrices with their coarse levels, pyramids, candidate pairs and recorded
// channels. Measured runs gave the memory per vertex: 2.5 kB for an implicit method without contact
// and bending, 6 kB with contact and bending. OpenGL contexts and the second run of
// --estimate-error are left out.
double estimate_memory(const Case& source, const SceneSize& size);

// Returns the index of the shape that needs the most memory. Bodies come first, then obstacles,
// then particles.
std::size_t largest_shape(const Case& source, const SceneSize& size);

// Returns compute.memory_limit or, if the case does not give it, default_memory_limit() (bytes).
double memory_limit(const Case& source);
// Returns nine tenths (bytes) of the machine's memory, or of the limit that this process's control
// group has, if that limit is less.
double default_memory_limit();

// Returns the reason to refuse a scene that exceeds the limit: "the scene needs about 570 GiB of
// memory, more than the limit of 21.2 GiB". Returns an empty text if the scene does not exceed it.
std::string reason_of_memory(const Case& source, const SceneSize& size);
inline constexpr const char* memory_hint =
    "expected fewer vertices, or a larger compute.memory_limit";

// Returns an amount of memory as text: "12.25 MiB", "21.2 GiB", "570 GiB".
std::string memory_text(double bytes);

}  // namespace weft::sim
