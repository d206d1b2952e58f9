// The work and cost of a run: counters and the times of its phases.
#pragma once

#include <chrono>
#include <cstdint>

#include "sim/base/step_census.h"

namespace weft::sim {

struct Counters {
  // Number of candidate lists, summed over all updates. There is one list per pair of neighbouring
  // bodies, and one per body with self-contact.
  std::int64_t body_pairs = 0;
  std::int64_t rebuilds = 0;            // pyramids rebuilt
  std::int64_t self_traversals = 0;     // pyramids traversed against themselves
  std::int64_t pair_traversals = 0;     // pairs of different pyramids traversed together
  std::int64_t bound_tests = 0;         // pairs of bounding volumes compared
  std::int64_t candidate_pairs = 0;     // feature pairs put on candidate lists
  std::int64_t narrow_phase_calls = 0;  // feature pairs whose distance or path was checked
  std::int64_t ccd_calls = 0;           // feature pairs checked by continuous collision detection
  std::int64_t friction_terms = 0;      // feature pairs whose friction was evaluated
  std::int64_t force_evaluations = 0;   // evaluations of the right-hand side
  std::int64_t matrix_assemblies = 0;
  std::int64_t sparse_factorisations = 0;  // of systems that wear conjugate gradients out
};

struct IntegratorCounts {
  std::int64_t steps = 0;
  std::int64_t vetoed_steps = 0;  // steps cut because surfaces would have touched or crossed
  std::int64_t error_test_failures = 0;
  std::int64_t convergence_failures = 0;
  std::int64_t newton_iterations = 0;
  std::int64_t linear_iterations = 0;
  std::int64_t linear_setups = 0;
  std::int64_t restarts = 0;  // restarts of the method without its history
  StepCensus census;          // of the accepted steps

  IntegratorCounts& operator+=(const IntegratorCounts& more) {
    steps += more.steps;
    vetoed_steps += more.vetoed_steps;
    error_test_failures += more.error_test_failures;
    convergence_failures += more.convergence_failures;
    newton_iterations += more.newton_iterations;
    linear_iterations += more.linear_iterations;
    linear_setups += more.linear_setups;
    restarts += more.restarts;
    census += more.census;
    return *this;
  }
};

// The wall times of the phases of a run (s). Phases do not overlap.
struct PhaseTimes {
  double rebuild = 0;
  double traverse = 0;
  double narrow_phase = 0;
  double forces = 0;
  double linear_solve = 0;
  double energies = 0;  // energies of steps and frames, and the energy watch
  double record = 0;    // gathering frames and writing them
};

struct Statistics {
  Counters counters;
  PhaseTimes phases;
};

// Adds the wall time from its construction to its destruction to one phase. While a nested timer of
// the same thread exists, only the nested timer counts.
class PhaseTimer {
 public:
  explicit PhaseTimer(double& phase) : phase_(phase), outer_(innermost()), start_(Clock::now()) {
    if (outer_ != nullptr) outer_->stop(start_);
    innermost() = this;
  }
  ~PhaseTimer() {
    const Clock::time_point now = Clock::now();
    stop(now);
    if (outer_ != nullptr) outer_->start_ = now;
    innermost() = outer_;
  }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  static PhaseTimer*& innermost() {
    static thread_local PhaseTimer* timer = nullptr;
    return timer;
  }
  void stop(Clock::time_point now) {
    phase_ += std::chrono::duration<double>(now - start_).count();
  }

  double& phase_;
  PhaseTimer* outer_;
  Clock::time_point start_;
};

}  // namespace weft::sim
