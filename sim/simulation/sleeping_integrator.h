// Lets bodies that have come to rest sleep, and wakes them when something touches them.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/integrator/integrator.h"
#include "sim/scene/awake_scene.h"
#include "sim/scene/scene_curves.h"
#include "sim/simulation/moving_boxes.h"
#include "sim/simulation/rest_watch.h"

namespace weft::sim {

// True if bodies of the scene may sleep. Conditions: time.sleep is on, the method computes motions,
// and there are at least two dynamic bodies.
bool may_sleep(const Scene& scene);

// Integrates a scene without its sleeping bodies. State arrays hold the whole scene. While bodies
// sleep, a dynamics and an integrator of the awake bodies compute their part of the state.
//
// A body may fall asleep under the following conditions:
// - it is at rest (rest_watch.h);
// - none of its pins moves, or will take hold or let go later;
// - it is not tied or sewn to a moving body or obstacle whose motion is prescribed;
// - for the next half second no obstacle moves near it;
// - for the next half second no curve that acts on it changes (scene_curves.h), and no seam of it
//   closes.
//
// Bodies that touch, or are tied or sewn to each other, form an island. An island falls asleep and
// wakes as a whole. At least one body stays awake. Bodies fall asleep only if together they have at
// least a tenth of the awake vertices, because the method must restart.
//
// For awake bodies, sleeping bodies are obstacles at rest. A step is taken back if, in any
// evaluation of its forces, a sleeping body is in reach of an awake body. It is also taken back if
// an obstacle may have come near a sleeping body, or if a curve that acts on a sleeping body
// changes. The sleeping body and its island wake at the start of that step, so no force on them is
// lost.
class SleepingIntegrator final : public Integrator {
 public:
  // `whole` is the dynamics of `scene`. Both must outlive the integrator.
  SleepingIntegrator(const Scene& scene, Dynamics& whole);
  // Sets a function that is called with a description after bodies have fallen asleep or woken and
  // the method has restarted. While transfer() reads, it is called with an empty text. Then the
  // sleeping bodies are known, but the method has not yet read its state. Must be set before the
  // first step or transfer().
  void set_after_change(std::function<void(const std::string&)> after_change) {
    after_change_ = std::move(after_change);
  }

  [[nodiscard]] std::optional<Failure> step() override;
  double time() const override { return integrator_->time(); }
  double last_step() const override { return integrator_->last_step(); }
  int last_order() const override { return integrator_->last_order(); }
  std::span<const double> state() const override {
    return awake_ ? std::span<const double>(state_) : integrator_->state();
  }
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const override;
  IntegratorCounts counts() const override {
    IntegratorCounts all = earlier_;
    return all += integrator_->counts();
  }
  // Wakes all bodies.
  void restart(double time, std::span<const double> y) override;
  void transfer(StateArchive& archive) override;
  void tighten() override { integrator_->tighten(); }
  std::string decision() const override { return integrator_->decision(); }

  // Returns the dynamics of the awake bodies.
  Dynamics& dynamics() const { return awake_ ? awake_->dynamics : whole_; }
  // Returns the state of dynamics() at time().
  std::span<const double> awake_state() const { return integrator_->state(); }
  // Returns the part of a state of the whole scene that belongs to awake bodies.
  std::vector<double> awake_part(std::span<const double> y) const;
  // Returns the energies of awake and sleeping bodies together.
  Energies with_asleep(const Energies& awake) const;
  // Returns the smallest gap (m) of awake and sleeping bodies together. `smallest_gap` is the
  // smallest gap of the awake bodies. Returns nothing if there is no gap.
  std::optional<double> with_asleep(std::optional<double> smallest_gap) const;
  int sleeping_bodies() const;
  // Returns a failure of the awake bodies, with its particle numbered as in the whole scene.
  Failure in_whole(Failure failure) const;

 private:
  struct Awake {
    Awake(const Scene& whole, std::span<const char> asleep, std::span<const Vec3> position,
          Dynamics& of_whole)
        : part(whole, asleep, position), dynamics(part.scene(), of_whole.statistics()) {
      dynamics.share_history(of_whole);
    }
    AwakeScene part;
    Dynamics dynamics;
  };

  std::vector<int> find_islands() const;
  std::vector<char> bodies_that_may_sleep(const std::vector<int>& islands) const;
  void fall_asleep();
  std::vector<int> touched_islands(double from) const;
  void wake(double now, const std::vector<int>& islands);
  void change(double now, const std::vector<int>& bodies, const char* event);
  void build();
  void find_frozen(double now);
  Eigen::AlignedBox3d box_of(int body) const;
  bool is_driven(int body, double from, double to) const;
  std::string described(const std::vector<int>& bodies, const std::string& event) const;

  const Scene& scene_;
  Dynamics& whole_;
  MovingBoxes moving_boxes_;
  SceneCurves curves_;
  std::function<void(const std::string&)> after_change_;
  // For each dynamic body, 1 if its pins or ties forbid sleep.
  std::vector<char> has_moving_pin_;
  RestWatch rest_;
  std::vector<char> asleep_;      // 1 for each dynamic body that sleeps
  std::vector<int> island_;       // island in which each dynamic body last fell asleep
  std::vector<Vec3> built_at_;    // positions (m) of dynamic particles when awake_ was built
  std::unique_ptr<Awake> awake_;  // null if all bodies are awake
  std::unique_ptr<Integrator> integrator_;
  std::vector<double> state_;         // state of the whole scene; kept only while bodies sleep
  Energies frozen_;                   // energies of sleeping bodies
  std::optional<double> frozen_gap_;  // smallest gap at sleeping bodies (m)
  IntegratorCounts earlier_;          // counts of earlier integrators
};

}  // namespace weft::sim
