// Lets pins take hold and let go at their times.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/integrator/integrator.h"
#include "sim/scene/timed_pins.h"
#include "sim/simulation/sleeping_integrator.h"

namespace weft::sim {

// Integrates a scene with timed pins. From one change of pins to the next, a dynamics and an
// integrator of their own simulate the scene with the vertices that are held then. Steps end at
// the changes, up to time.minimum_step, and the method begins anew there. States are those of the
// whole scene, with held vertices in their place.
//
// A vertex that is let go keeps the velocity of its pin; where that jumps at the time, the one
// before the jump. A vertex that is taken hold of gets the velocity of its pin at once.
class TimedPinsIntegrator final : public Integrator {
 public:
  // `whole` is the dynamics of `scene`; both must outlive the integrator.
  TimedPinsIntegrator(const Scene& scene, Dynamics& whole);
  // Sets a function that is called as that of SleepingIntegrator: after pins have changed, and
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

  // The dynamics with the vertices that are held at time(), of all bodies.
  Dynamics& dynamics() const { return stage_->dynamics; }
  // The integrator inside if bodies may sleep, else null. Changes with the pins.
  SleepingIntegrator* sleeping() const { return stage_->sleeping; }

 private:
  struct Stage {
    Stage(Scene held, Statistics& statistics)
        : scene(std::move(held)), dynamics(scene, statistics) {}
    Scene scene;
    Dynamics dynamics;
    std::unique_ptr<Integrator> integrator;
    SleepingIntegrator* sleeping = nullptr;
  };

  bool is_change_due() const;
  void change();
  void build();
  void copy_state();

  const Scene& scene_;
  Dynamics& whole_;
  std::function<void(const std::string&)> after_change_;
  double event_ = 0;              // s, of the last change of pins
  std::vector<TimedHold> holds_;  // since then
  std::vector<Vec3> built_at_;    // m, of dynamic particles at that time
  std::unique_ptr<Stage> stage_;
  std::vector<double> state_;  // with held vertices in their place; kept only while pins move
  IntegratorCounts earlier_;   // of earlier integrators
};

}  // namespace weft::sim
