// Makers of the integrators, one per file; called through make_integrator().
#pragma once

#include <memory>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Variable-order, variable-step BDF by CVODE (cvode_integrator.h).
std::unique_ptr<Integrator> make_cvode_integrator(const Scene& scene, Dynamics& dynamics);

// Runge-Kutta methods with error control by ARKODE. TR-BDF2 is implicit, of order 2. Without
// contact, an explicit method of order 4 replaces it when that should cost less. decision() names
// the method in use.
std::unique_ptr<Integrator> make_arkode_integrator(const Scene& scene, Dynamics& dynamics);

// Backward Euler by KINSOL, of order 1: y1 - h f(t1, y1) = y0. Steps are `time.step` long or,
// without it, as long as the tolerances allow.
std::unique_ptr<Integrator> make_euler_integrator(const Scene& scene, Dynamics& dynamics);

// Equilibria under the loading of the case (StaticCase). By default, loads grow with time: gravity
// and applied loads times t / duration, with prescribed motions at t. Each frame is an equilibrium
// at one load, found by Relaxation.
std::unique_ptr<Integrator> make_static_integrator(const Scene& scene, Dynamics& dynamics);

// Equilibria at the times of frames, under the loads and motions of these times
// (quasi_static_integrator.cpp): Newton's method leads from one equilibrium to the next. If it
// fails, the time between them is divided.
std::unique_ptr<Integrator> make_quasi_static_integrator(const Scene& scene, Dynamics& dynamics);

// Points on the path of equilibria under loads that are scaled by one factor
// (arc_length_integrator.cpp). Each frame is one point, one arc length after the last.
std::unique_ptr<Integrator> make_arc_length_integrator(const Scene& scene, Dynamics& dynamics);

// Implicit midpoint rule by KINSOL, of order 2, in steps of `time.step`: y1 = y0 + h f(t + h/2, (y0
// + y1) / 2). It conserves the energy of linear motions.
std::unique_ptr<Integrator> make_midpoint_integrator(const Scene& scene, Dynamics& dynamics);
// Velocity Verlet: explicit, of order 2. A `time.step` beyond the limit of stability at the start
// is refused. Without time.step, steps are a fraction of the longest stable step and adapt to it as
// the body deforms.
std::unique_ptr<Integrator> make_verlet_integrator(const Scene& scene, Dynamics& dynamics);

}  // namespace weft::sim
