#include "sim/case/time_methods.h"

#include <array>

namespace weft::sim {

namespace {

using Steps = TimeMethodTraits::Steps;

// Columns: method, name, title, order, steps, is_explicit, is_calibrated.
constexpr std::array methods{
    TimeMethodTraits{TimeMethod::cvode, "cvode", "CVODE, BDF", 5, Steps::chosen, false, true},
    TimeMethodTraits{TimeMethod::arkode, "arkode", "ARKODE, Runge-Kutta", 4, Steps::chosen, false,
                     true},
    TimeMethodTraits{TimeMethod::euler, "euler", "backward Euler", 1, Steps::either, false, true},
    TimeMethodTraits{TimeMethod::static_loads, "static", "equilibria under growing loads", 0,
                     Steps::loads, false, false},
    TimeMethodTraits{TimeMethod::implicit_midpoint, "implicit_midpoint", "implicit midpoint", 2,
                     Steps::fixed, false, false},
    TimeMethodTraits{TimeMethod::verlet, "verlet", "Verlet", 2, Steps::either, true, false},
    TimeMethodTraits{TimeMethod::impulses, "impulses", "impulses between rigid particles", 2,
                     Steps::either, true, false},
};

static_assert(is_in_order_of_methods(methods));

}  // namespace

std::span<const TimeMethodTraits> time_methods() { return methods; }

const TimeMethodTraits& traits_of(TimeMethod method) {
  return methods[static_cast<std::size_t>(method)];
}

}  // namespace weft::sim
