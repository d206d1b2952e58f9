// Newton's method for equilibria, with a direct solver.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/integrator/safe_path.h"
#include "sim/motion/dynamics.h"
#include "sim/solver/tangent_factors.h"

namespace weft::sim {

// Solves F(x) = kept for the free particles. `kept` (N) is zero except in homotopies (see keep()).
// A state is an equilibrium if a full correction moves no particle by more than
// time.position_tolerance, and at least one of two conditions holds:
// - The 2-norm of the residual is at most 1e-8 of that of the applied forces: loads, weight and
//   forces on held particles.
// - The correction moves no particle by more than 1e-8 of the size of the bodies. This condition is
//   for thin bodies: their residual stalls, because rounded positions stretch the stiff membrane.
class EquilibriumNewton {
 public:
  EquilibriumNewton(const Scene& scene, Dynamics& dynamics);

  enum class End { converged, diverged, singular, blocked, stopped };
  // The target and the strategy of a search.
  struct Goal {
    double time = 0;  // s
    // If true, corrections that are long or overshoot are shortened, and an indefinite tangent is
    // replaced by a semi-definite one, if that is regular. The search then diverges less often but
    // may take more iterations.
    bool careful = false;
    std::function<bool()> should_stop;  // if it returns true, the search ends
  };
  // Moves the free particles of `y` (6 * particles doubles) to an equilibrium. Precondition: `path`
  // is at `y`. Cost per iteration: one factorisation (up to three if careful) and usually one
  // evaluation of the forces.
  End solve(const Goal& goal, std::span<double> y, SafePath& path);

  // Evaluates residual() at (time, y) and at the load set in the dynamics. Returns false and sets
  // fault() if the forces cannot be evaluated.
  bool evaluate(double time, std::span<const double> y);
  // Assembles and factorises the tangent at (time, y). Precondition: this is the state of the last
  // evaluate(). Returns false if the tangent is singular.
  bool factorise(double time, std::span<const double> y,
                 Definiteness definiteness = Definiteness::exact);
  // Returns the residual force (N) on each dynamic particle in the last successful evaluate(); zero
  // for held particles.
  const std::vector<Vec3>& residual() const { return residual_; }
  const TangentFactors& factors() const { return factors_; }
  // True if (time, y) is an equilibrium as defined at the class. Preconditions: the last evaluate()
  // was at this state, and the last correction moved particles by up to `move` (m).
  bool is_converged(double time, std::span<const double> y, double move);

  // Sets `kept`, the forces (N) that solve() leaves unbalanced. An empty vector means zero.
  void keep(std::vector<Vec3> forces) { kept_ = std::move(forces); }
  // Returns the diagonal (m) of the box around the initial positions of the dynamic bodies.
  double size() const { return size_; }
  const std::optional<ContactFault>& fault() const { return fault_; }
  // Returns the particle with the largest residual in the last evaluation.
  int worst_particle() const;

  // Returns the number of negative eigenvalues of the last regular exact tangent.
  int negative_directions() const { return negative_; }
  // Returns the largest number of negative eigenvalues of a regular exact tangent since
  // forget_signs().
  int most_negative_directions() const { return most_negative_; }
  void forget_signs() { most_negative_ = 0; }

  std::int64_t iterations() const { return iterations_; }
  std::int64_t factorisations() const { return factorisations_; }
  void transfer(StateArchive& archive) { archive(iterations_, factorisations_, negative_); }

 private:
  bool find_way(const Goal& goal, std::span<const double> y);
  double take_way(const Goal& goal, std::span<double> y, SafePath& path);
  double pull() const;

  const Scene& scene_;
  Dynamics& dynamics_;
  TangentFactors factors_;
  double size_ = 0;  // m
  std::vector<Vec3> force_, residual_, way_, applied_, kept_;
  std::vector<double> reached_;
  std::optional<ContactFault> fault_;
  int negative_ = 0, most_negative_ = 0;
  std::int64_t iterations_ = 0, factorisations_ = 0;
};

// Returns the largest length of the vectors.
double largest_length(std::span<const Vec3> vectors);

}  // namespace weft::sim
