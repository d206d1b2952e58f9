// Makers of the integrators, one file each; called through make_integrator().
#pragma once

#include <memory>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Backward Euler by KINSOL: y1 - h f(t1, y1) = y0, of order 1. Steps of `time.step`, or, where that
// is not given, as long as the tolerances allow.
std::unique_ptr<Integrator> make_euler_integrator(const Scene& scene, Dynamics& dynamics);

}  // namespace weft::sim
