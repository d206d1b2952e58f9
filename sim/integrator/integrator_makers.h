// Makers of the integrators, one per file; called through make_integrator().
#pragma once

#include <memory>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Variable-order, variable-step BDF by CVODE (cvode_integrator.h).
std::unique_ptr<Integrator> make_cvode_integrator(const Scene& scene, Dynamics& dynamics);

// Runge-Kutta methods with error control by ARKODE. TR-BDF2 is implicit, of order 2. Without
// contact, an explicit method of order 4 replaces it where it should cost less. decision() names
// the present one.
std::unique_ptr<Integrator> make_arkode_integrator(const Scene& scene, Dynamics& dynamics);

// Backward Euler by KINSOL, of order 1: y1 - h f(t1, y1) = y0. Steps are `time.step` long or,
// without it, as long as the tolerances allow.
std::unique_ptr<Integrator> make_euler_integrator(const Scene& scene, Dynamics& dynamics);

// Equilibria by the loading of the case (StaticCase). By default loads grow with time: gravity
// times t / duration, and the prescribed motions at t. Each frame is a load. It is reached by
// pseudo-steps of one Newton iteration each, which turn into Newton's method as they grow
// (static_integrator.cpp).
std::unique_ptr<Integrator> make_static_integrator(const Scene& scene, Dynamics& dynamics);

// Equilibria at the times of frames, under the loads and motions of these times
// (quasi_static_integrator.cpp): Newton's method from equilibrium to equilibrium. Where it fails,
// the time is divided.
std::unique_ptr<Integrator> make_quasi_static_integrator(const Scene& scene, Dynamics& dynamics);

// Points on the path of equilibria under loads times one factor, by arc length
// (arc_length_integrator.cpp). A step from frame to frame is a step along the path.
std::unique_ptr<Integrator> make_arc_length_integrator(const Scene& scene, Dynamics& dynamics);

// Implicit midpoint rule by KINSOL, of order 2, in steps of `time.step`: y1 = y0 + h f(t + h/2, (y0
// + y1) / 2). It conserves the energy of linear motions.
std::unique_ptr<Integrator> make_midpoint_integrator(const Scene& scene, Dynamics& dynamics);
// Velocity Verlet: explicit, of order 2. A `time.step` beyond the limit of stability at the start
// is refused. Without time.step, steps are a fraction of the longest stable one, which they follow
// as the body deforms.
std::unique_ptr<Integrator> make_verlet_integrator(const Scene& scene, Dynamics& dynamics);

}  // namespace weft::sim
