// Functions that make the integrators of all methods and loadings. make_integrator() chooses one.
#pragma once

#include <memory>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Variable-order, variable-step BDF by CVODE (cvode_integrator.h).
std::unique_ptr<Integrator> make_cvode_integrator(const Scene& scene, Dynamics& dynamics);

// Runge-Kutta methods with error control, by SUNDIALS ARKODE. Steps are implicit by TR-BDF2, of
// order 2. Without contact, an explicit method of order 4 replaces TR-BDF2 while explicit steps
// should cost less. decision() names the method in use.
std::unique_ptr<Integrator> make_arkode_integrator(const Scene& scene, Dynamics& dynamics);

// Backward Euler, of order 1: y1 - h f(t1, y1) = y0. Steps have the length `time.step` unless they
// are cut (one_step_integrator.h). Without time.step, error control chooses their lengths.
std::unique_ptr<Integrator> make_euler_integrator(const Scene& scene, Dynamics& dynamics);

// Equilibria under the loading of the case (StaticCase). By default, Relaxation finds an
// equilibrium for every frame. At time t, gravity and applied loads have the factor t / duration,
// and prescribed motions have the positions of t. Other loadings use make_quasi_static_integrator()
// or make_arc_length_integrator().
std::unique_ptr<Integrator> make_static_integrator(const Scene& scene, Dynamics& dynamics);

// Equilibria at the times of frames, under the loads and motions of these times
// (quasi_static_integrator.cpp): Newton's method leads from one equilibrium to the next. If it
// fails, an equilibrium at a time in between is found first.
std::unique_ptr<Integrator> make_quasi_static_integrator(const Scene& scene, Dynamics& dynamics);

// Points on the path of equilibria under loads that are scaled by one factor
// (arc_length_integrator.cpp). Each step leads to the next point, one arc length away.
std::unique_ptr<Integrator> make_arc_length_integrator(const Scene& scene, Dynamics& dynamics);

// Implicit midpoint rule, of order 2: y1 = y0 + h f(t + h/2, (y0 + y1) / 2). Steps have the length
// `time.step` unless they are cut. The rule conserves the energy of linear undamped motions.
std::unique_ptr<Integrator> make_midpoint_integrator(const Scene& scene, Dynamics& dynamics);
// Velocity Verlet: explicit, of order 2. A `time.step` beyond the limit of stability at the start
// is refused. Without time.step, steps are a fraction of the longest stable step. Without contact,
// they adapt to it as the body deforms.
std::unique_ptr<Integrator> make_verlet_integrator(const Scene& scene, Dynamics& dynamics);

// Rigid spheres that collide with each other and with obstacles by impulses, of order 2 between
// impacts (sim/particles/impulse_solver.h). Steps are cut such that no sphere moves by more than
// 3/4 of the smallest radius. No accepted state has an overlap. SUNDIALS takes no part: there is no
// system of equations to solve but the projected one of the impulses.
std::unique_ptr<Integrator> make_impulse_integrator(const Scene& scene, Dynamics& dynamics);

}  // namespace weft::sim
