// The springs of cloth whose membrane is made of springs.
#pragma once

#include <array>
#include <vector>

#include "materials/spring.h"
#include "sim/forces/varying_numbers.h"

namespace weft::sim {

struct Scene;

struct SpringNetwork {
  std::vector<std::array<int, 2>> ends;  // dynamic particles at the ends
  std::vector<materials::Spring> springs;
  VaryingNumbers damping_times;  // s, by spring
  bool is_damped = false;        // true if damped at any time
};

// Returns the springs of all dynamic bodies whose membrane is made of springs.
SpringNetwork springs_of(const Scene& scene);

}  // namespace weft::sim
