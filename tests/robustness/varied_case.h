// A case turned as a whole and disturbed a little: the same physics, other numbers.
#pragma once

#include <cstdint>

#include "sim/case/case.h"

namespace weft::robustness {

// Relative size of the disturbances.
constexpr double jitter = 1e-6;

// Returns the case with everything in the world turned by one random rotation about the origin:
// bodies, obstacles, prescribed motion, gravity, wind and loads. Every body is also shifted by up
// to `jitter` times its size, turned by up to `jitter` rad and, unless it is a shell, stretched by
// factors within 1 +- `jitter`: shells of metal would ring. Equal seeds give equal cases. Throws
// std::invalid_argument for a case that names directions or places of the world in a form that
// cannot turn: a region, or `axes` of a pin. A case with particles does not turn.
sim::Case varied(const sim::Case& source, std::uint32_t seed);

}  // namespace weft::robustness
