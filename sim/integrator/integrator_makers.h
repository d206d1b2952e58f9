// Makers of the integrators, one file each; called through make_integrator().
#pragma once

#include <memory>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Variable-order, variable-step BDF by CVODE (cvode_integrator.h).
std::unique_ptr<Integrator> make_cvode_integrator(const Scene& scene, Dynamics& dynamics);

// Runge-Kutta methods with error control by ARKODE: TR-BDF2, implicit, of order 2; or, without
// contact, an explicit one of order 4 where that promises to cost less. decision() says which.
std::unique_ptr<Integrator> make_arkode_integrator(const Scene& scene, Dynamics& dynamics);

// Backward Euler by KINSOL: y1 - h f(t1, y1) = y0, of order 1. Steps of `time.step`, or, where that
// is not given, as long as the tolerances allow.
std::unique_ptr<Integrator> make_euler_integrator(const Scene& scene, Dynamics& dynamics);

// Equilibrium under loads that grow with the time: gravity times t / duration, and the motions of
// pins and obstacles at t. Each frame is a load, reached through pseudo-steps of one Newton
// iteration each, which become Newton's method as they grow (static_integrator.cpp).
std::unique_ptr<Integrator> make_static_integrator(const Scene& scene, Dynamics& dynamics);

// Implicit midpoint by KINSOL, in steps of `time.step`: y1 = y0 + h f(t + h/2, (y0 + y1) / 2), of
// order 2; keeps the energy of linear motions.
std::unique_ptr<Integrator> make_midpoint_integrator(const Scene& scene, Dynamics& dynamics);
// Velocity Verlet: explicit, of order 2. Steps of `time.step`, refused where that is beyond the
// limit of stability at the start; or, where it is not given, a share of the longest stable step,
// which they follow as the body deforms.
std::unique_ptr<Integrator> make_verlet_integrator(const Scene& scene, Dynamics& dynamics);

}  // namespace weft::sim
