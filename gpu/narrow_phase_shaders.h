// The compute shaders (GLSL 4.50) of the narrow phase, and the layouts of their buffers (std430).
// Private to gpu/.
#pragma once

#include <cstdint>
#include <string>

#include "gpu/compute_narrow_phase.h"

namespace weft::gpu::shaders {

// A ContactGroup in the layout of the shaders.
struct Group {
  double thickness = 0, reach = 0, range = 0;  // reach = thickness + range, m
  double damping_time = 0, friction = 0, friction_speed = 0;
  double spin[3]{};
  float limit = 0;
  std::uint32_t flags = 0;
};
namespace group_flags {
inline constexpr std::uint32_t edges = 1, samples = 2, obstacle = 4;
}

// A contribution to the sum over the features around a sample, while it is formed. Contributions
// with one closest feature are merged.
struct Contribution {
  std::uint32_t feature[2]{};  // the points of an edge, a point twice, or no_point and a candidate
  std::uint32_t candidate = 0;
  std::uint32_t source_and_coefficient = 0;  // source + 8 coefficient
};

// Flags that apply_law sets in ContactTerm::flags.
namespace term_flags {
inline constexpr std::uint32_t slides = 1, mollified = 2;
}

// Returns the GLSL that both shaders begin with: the input and the list of terms, and the closest
// points of candidates and of the edges and corners of triangles. Unless the device
// `rounds_like_the_cpu`, quotients and roots are refined.
std::string candidates_and_closest_points(bool rounds_like_the_cpu);
// Returns the shader that decides which features are in reach. An invocation takes one row. It
// appends the terms of the row to the list of terms, one after another, and lowers the index of the
// first candidate that touches.
std::string find_terms(bool rounds_like_the_cpu);
// Returns the shader that computes barrier, damping and friction of a term. An invocation takes one
// term.
std::string apply_law(bool rounds_like_the_cpu);

// GLSL: log_of(x), the natural logarithm of a normal positive number, within 1 unit in the last
// place if the device rounds like the CPU. GLSL 4.50 has no logarithm for float64.
extern const char* const logarithm;

}  // namespace weft::gpu::shaders
