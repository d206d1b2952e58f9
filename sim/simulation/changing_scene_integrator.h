// Integrates scenes whose pins begin or cease to hold vertices at given times, and whose ties
// break.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/forces/tie_springs.h"
#include "sim/integrator/integrator.h"
#include "sim/scene/timed_pins.h"
#include "sim/simulation/sleeping_integrator.h"

namespace weft::sim {

// True if the scene changes during a run: it has timed pins, or a tie may break.
bool changes_in_time(const Scene& scene);

// Integrates a scene that changes. The time between two changes is a stage. Each stage has its own
// dynamics and integrator, for the vertices that pins hold and the ties that are intact in that
// stage. The method restarts at every change. State arrays hold the whole scene, with held vertices
// at their prescribed positions.
//
// A step ends at each change of pins, to within time.minimum_step. If a tie carries more than its
// break_force at the end of a step, interpolation shortens the step to the time when the tie
// reached this force. If surfaces meet in an interpolated state, the tie breaks at the end of the
// step instead. The scene changes at the start of the next step, so states within a step belong to
// the pins and ties of that step.
//
// A released vertex keeps the velocity that its pin had before the release. A vertex that a pin
// begins to hold gets the velocity of the pin at once.
class ChangingSceneIntegrator final : public Integrator {
 public:
  // `whole` is the dynamics of `scene`. Both must outlive the integrator.
  ChangingSceneIntegrator(const Scene& scene, Dynamics& whole);
  // Sets a function that is called with a description after pins or ties have changed, and in the
  // cases of SleepingIntegrator::set_after_change(). Must be set before the first step or
  // transfer().
  void set_after_change(std::function<void(const std::string&)> after_change) {
    after_change_ = std::move(after_change);
  }

  [[nodiscard]] std::optional<Failure> step() override;
  double time() const override { return breaks_at_.value_or(stage_->integrator->time()); }
  double last_step() const override {
    return is_shortened() ? *breaks_at_ - before_ : stage_->integrator->last_step();
  }
  int last_order() const override { return stage_->integrator->last_order(); }
  std::span<const double> state() const override {
    return state_.empty() ? stage_->integrator->state() : std::span<const double>(state_);
  }
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const override;
  IntegratorCounts counts() const override {
    IntegratorCounts all = earlier_;
    return all += stage_->integrator->counts();
  }
  void restart(double time, std::span<const double> y) override;
  void transfer(StateArchive& archive) override;
  void tighten() override { stage_->integrator->tighten(); }
  std::string decision() const override { return stage_->integrator->decision(); }

  // Returns the dynamics of all bodies, with the held vertices and intact ties of the last step.
  Dynamics& dynamics() const { return stage_->dynamics; }
  // Returns the integrator of the present stage if it lets bodies sleep, else null. Each new stage
  // replaces it.
  SleepingIntegrator* sleeping() const { return stage_->sleeping; }
  // Returns the part of state() that belongs to awake bodies.
  std::span<const double> awake_state() const {
    if (stage_->sleeping == nullptr) return state();
    return is_shortened() ? std::span<const double>(awake_state_) : stage_->sleeping->awake_state();
  }
  // True if ties that break have shortened the last step. The forces were last evaluated beyond
  // time().
  bool is_shortened() const { return breaks_at_ && *breaks_at_ < stage_->integrator->time(); }

 private:
  struct Stage {
    Stage(Scene now, Dynamics& whole);
    Scene scene;
    Dynamics dynamics;
    mutable std::vector<TieSprings> breakable;  // ties with a break_force, in the scene's order
    std::unique_ptr<Integrator> integrator;
    SleepingIntegrator* sleeping = nullptr;
  };

  bool is_change_due() const;
  void change_pins();
  void end_step_at(double breaking);
  void find_awake_state();
  void break_ties();
  double overload(double time, std::span<const double> y) const;
  double breaking_time() const;
  void begin_stage(double now, std::span<const double> y);
  void build();
  void copy_state();

  const Scene& scene_;
  Dynamics& whole_;
  std::function<void(const std::string&)> after_change_;
  double event_ = 0;              // time of the last change of pins (s)
  std::vector<TimedHold> holds_;  // vertices held by timed pins since event_
  std::vector<int> broken_;       // numbers of the broken ties
  double before_ = 0;             // start of the last step (s)
  // End of the last step (s), if ties break there.
  std::optional<double> breaks_at_;
  std::vector<Vec3> built_at_;  // positions (m) of dynamic particles when stage_ was built
  std::unique_ptr<Stage> stage_;
  // The state at time(), with held vertices placed. Empty unless pins move or the step is
  // shortened.
  std::vector<double> state_;
  std::vector<double> awake_state_;  // awake part of state_, if the step is shortened
  IntegratorCounts earlier_;         // counts of earlier stages
};

}  // namespace weft::sim
