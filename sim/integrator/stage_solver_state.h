// The state of StageSolver, and the functions of its two files: stage_solver.cpp iterates until
// convergence, given_corrections.cpp by a given number of corrections.
#pragma once

#include <kinsol/kinsol.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/integrator/newton_solver.h"
#include "sim/integrator/stage_solver.h"
#include "sim/integrator/sundials_access.h"
#include "sim/motion/external_work.h"
#include "sim/solver/velocity_system.h"

namespace weft::sim {

struct StageSolver::Implementation {
  Implementation(const Scene& scene_, Dynamics& dynamics_, int newton_count_)
      : scene(scene_), dynamics(dynamics_), newton_count(newton_count_) {}
  ~Implementation() {
    if (kinsol == nullptr) return;
    KINFree(&kinsol);
    SUNLinSolFree(newton_solver);
    for (N_Vector v : {u, step_scale, residual_scale}) N_VDestroy(v);
    SUNContext_Free(&context);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void create();
  VelocitySystem& velocity_system() { return system ? *system : velocity_system_of(newton_solver); }
  int residual(std::span<const double> y, std::span<double> r);
  int assemble(std::span<const double> state);
  void assemble_joined();
  bool make_definite();
  void guess(std::span<double> y);
  void guess_pins(std::span<double> y);
  void limit(std::span<double> correction);
  int multiply_correction(std::span<double> product) const;
  bool path_is_safe(std::span<const double> state);
  Outcome outcome(int flag) const;
  int run_kinsol(int strategy);
  Outcome iterate(int strategy, int most_iterations);
  bool is_driven() const;
  bool leaves_small_residual(std::span<const double> residual);
  bool can_compare_energies() const;
  double held_energy() const;
  double work_of_wind_and_loads(std::span<const double> y);
  bool is_too_long(std::span<const double> y);
  void subtract_accelerations(std::span<double> from);
  void add_stop_forces(std::span<const double> y);
  Outcome correct(std::span<double> y);
  bool add_stops(std::span<const double> y, int* added);
  bool correct_friction(std::span<const double> y);
  Outcome iterate_by_number(std::span<double> y);

  const Scene& scene;
  Dynamics& dynamics;
  int newton_count;
  // Replaces KINSOL and its linear solver if the number of iterations is given.
  std::optional<VelocitySystem> system;
  std::vector<double> right, solution, weight;
  std::vector<double> slope;  // (y - a) / gamma of the last stage; empty if unknown or with contact
  SUNContext context = nullptr;
  void* kinsol = nullptr;
  SUNLinearSolver newton_solver = nullptr;
  N_Vector u = nullptr, step_scale = nullptr, residual_scale = nullptr;
  std::int64_t newton_iterations = 0, linear_iterations = 0, linear_setups = 0;

  // The arguments of the present solve(): t (s), gamma (s), start of the step (s), `a` and `start`.
  double time = 0, gamma = 0, start_time = 0;
  std::span<const double> right_side;
  const std::vector<Vec3>* start = nullptr;
  bool definite = false, shortened = false;
  // Energies (J) at the start of a step by a given number of corrections with contact, those of
  // held particles, and the work of the step. `driven_work` is empty unless a motion has
  // moved particles.
  Energies before;
  double held_before = 0;
  std::optional<ExternalWork> driven_work;
  double gap_change = 0;  // by the last correction; Contact::largest_relative_gap_change()
  double kept_part = 1;   // fraction of the present correction that limit() kept
  // Views of the state of the last assembly, and of the last residual.
  std::span<const double> linearised_at, last_residual;
  std::vector<double> trial;
  std::vector<double> free_residual;  // residual without the forces of stops
  std::vector<Mat3> diagonal;         // of the linear system, without stops
  std::vector<Vec3> added_force;      // N, of stops, or by which friction changes
  std::vector<Vec3> displacement, change;
  std::vector<Vec3> position, velocity;
  std::optional<ContactFault> fault;
};

}  // namespace weft::sim
