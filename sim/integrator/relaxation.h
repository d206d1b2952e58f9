// The relaxation of bodies to an equilibrium by pseudo-steps of backward Euler.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/integrator/safe_path.h"
#include "sim/motion/dynamics.h"
#include "sim/solver/velocity_system.h"

namespace weft::sim {

// Returns the root mean square (m/s^2), weighted by mass, of the accelerations that full gravity
// and the loads at their present factor would cause alone.
double applied_acceleration(Dynamics& dynamics, double time, std::span<const double> y);

// Finds a stable equilibrium that may be far from the start, as for slack cloth. A pseudo-step is
// one Newton iteration of backward Euler from rest. Short pseudo-steps move particles along the
// forces. Long pseudo-steps approach Newton's method for the equilibrium. If the search is slow and
// bodies can be softened, it continues with softened bodies.
class Relaxation {
 public:
  Relaxation(const Scene& scene, Dynamics& dynamics);

  enum class End { at_rest, slow, stuck, blocked };
  // The target of a search.
  struct Goal {
    double time = 0;  // s
    // Scale of the limit for the residual (m/s^2), from applied_acceleration().
    double acceleration = 0;
    // If true, the search may end where only Newton's method is still to converge. If false, it
    // ends at an equilibrium.
    bool approaches = false;
    std::function<bool()> should_stop;  // if it returns true, the search ends
  };
  // Relaxes the free particles of `y` (6 * particles doubles). Preconditions: the velocities are
  // zero, and `path` has started at the last accepted state. After End::blocked, fault() holds the
  // reason. The dynamics have full stiffness at the end.
  End relax(const Goal& goal, std::span<double> y, SafePath& path);

  const std::optional<ContactFault>& fault() const { return fault_; }
  // Returns the particle with the largest residual acceleration in the last evaluation.
  int worst_particle() const;
  std::int64_t newton_iterations() const { return newton_iterations_; }
  std::int64_t linear_iterations() const { return linear_iterations_; }
  void transfer(StateArchive& archive) {
    archive(newton_iterations_, linear_iterations_);
    system_.transfer(archive);
  }

 private:
  End descend_at(double hardness, std::span<double> y, int most_steps);
  bool find_direction(std::span<const double> y);
  VelocitySystem::Outcome solve(std::span<const double> y, Definiteness definiteness);
  double take_correction(std::span<double> y);
  double pull() const;
  bool path_is_safe(std::span<const double> y);
  double longest_useful_step();
  double judging_step(bool approaches);
  bool is_near_rest(std::span<const double> y, bool softened, bool approaches);
  double residual_acceleration(std::span<const double> y) const;
  double least_hardness() const;

  const Scene& scene_;
  Dynamics& dynamics_;
  VelocitySystem system_;
  const Goal* goal_ = nullptr;  // the goal of the present search
  SafePath* path_ = nullptr;
  std::optional<ContactFault> fault_;
  double pseudo_step_ = 0;  // length of the present pseudo-step (s)
  int pseudo_steps_ = 0;    // number of pseudo-steps taken in the present search
  bool is_exact_ = false;   // true if linear solves serve the judgement of an equilibrium
  // Number of pseudo-steps since an exact matrix was indefinite, counting that pseudo-step; 0 if
  // the last exact matrix was not indefinite.
  int indefinite_steps_ = 0;
  std::int64_t newton_iterations_ = 0, linear_iterations_ = 0;
  std::vector<double> rate_, right_, correction_, reached_;
  std::vector<double> weight_;  // weights of the linear solves, all 1
  double mass_ = 0;             // mass of all dynamic particles (kg)
  double size_ = 0;             // diagonal of the box around their initial positions (m)
};

}  // namespace weft::sim
