// Lets pins take hold and let go at their times, and lets ties break.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/forces/tie_springs.h"
#include "sim/integrator/integrator.h"
#include "sim/scene/timed_pins.h"
#include "sim/simulation/sleeping_integrator.h"

namespace weft::sim {

// True if the scene changes in the course of a run: it has timed pins, or a tie may break.
bool changes_in_time(const Scene& scene);

// Integrates a scene that changes. For the time between two changes it makes a dynamics and an
// integrator, for the vertices that pins hold then and the ties that are intact. Steps end at the
// changes of pins, up to time.minimum_step. If a tie carries more than its break_force at the end
// of a step, the step is shortened to the time when it reached that force, by interpolation. The
// method begins anew at every change. States are those of the whole scene, with held vertices in
// their place.
//
// A vertex that is let go keeps the velocity of its pin; if that jumps at this time, the velocity
// before the jump. A vertex that is taken hold of gets the velocity of its pin at once.
class ChangingSceneIntegrator final : public Integrator {
 public:
  // `whole` is the dynamics of `scene`; both must outlive the integrator.
  ChangingSceneIntegrator(const Scene& scene, Dynamics& whole);
  // Sets a function that is called after pins or ties have changed and, as by SleepingIntegrator,
  // after bodies have fallen asleep or woken. Must be set before the first step.
  void set_after_change(std::function<void(const std::string&)> after_change) {
    after_change_ = std::move(after_change);
  }

  [[nodiscard]] std::optional<Failure> step() override;
  double time() const override { return stage_->integrator->time(); }
  double last_step() const override { return stage_->integrator->last_step(); }
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
  [[nodiscard]] bool transfer(StateArchive& archive) override;
  std::string decision() const override { return stage_->integrator->decision(); }

  // The dynamics of all bodies, with the vertices held and the ties intact at time().
  Dynamics& dynamics() const { return stage_->dynamics; }
  // The integrator inside if bodies may sleep, else null. Changes with the scene.
  SleepingIntegrator* sleeping() const { return stage_->sleeping; }

 private:
  struct Stage {
    Stage(Scene now, Dynamics& whole);
    Scene scene;
    Dynamics dynamics;
    mutable std::vector<TieSprings> breakable;  // of the scene's ties with a break_force, in order
    std::unique_ptr<Integrator> integrator;
    SleepingIntegrator* sleeping = nullptr;
  };

  bool is_change_due() const;
  void change_pins();
  void break_ties();
  double overload(double time, std::span<const double> y) const;
  double breaking_time() const;
  void begin_stage(double now, std::span<const double> y);
  void build();
  void copy_state();

  const Scene& scene_;
  Dynamics& whole_;
  std::function<void(const std::string&)> after_change_;
  double event_ = 0;              // s, of the last change of pins
  std::vector<TimedHold> holds_;  // since then
  std::vector<int> broken_;       // numbers of ties
  double before_ = 0;             // s, start of the last step
  std::vector<Vec3> built_at_;    // m, of dynamic particles when stage_ was made
  std::unique_ptr<Stage> stage_;
  std::vector<double> state_;  // with held vertices in their place; kept only while pins move
  IntegratorCounts earlier_;   // of earlier integrators
};

}  // namespace weft::sim
