// Lets bodies that have come to rest sleep, and wakes them when they are touched.
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

// True if bodies of the scene may sleep: time.sleep is on, the method follows motion in time, and
// there are at least two dynamic bodies.
bool may_sleep(const Scene& scene);

// Integrates a scene without the bodies that sleep. States are those of the whole scene. While
// bodies sleep, a dynamics and an integrator of the awake ones alone compute the states.
//
// A body may sleep if it is at rest (rest_watch.h), none of its pins moves or is still to take hold
// or let go, it is not tied to anything whose motion is prescribed, no obstacle moves near it and
// no curve that acts on it (scene_curves.h) changes within the next half second. Bodies in contact
// with each other, or tied or sewn to each other, fall asleep and wake together. At least one body stays
// awake. Bodies fall asleep only if they make up at least a tenth of the awake vertices, since the
// method then begins anew.
//
// Sleeping bodies are obstacles at rest to all others. A step in which any evaluation of the forces
// finds one in reach of an awake body, in which an obstacle may have come near it, or in which a
// curve that acts on it changes, is taken back: the body wakes at the start of the step. So no
// force on it is lost.
class SleepingIntegrator final : public Integrator {
 public:
  // `whole` is the dynamics of `scene`; both must outlive the integrator.
  SleepingIntegrator(const Scene& scene, Dynamics& whole);
  // Sets a function that is called with a description after bodies have fallen asleep or woken and
  // the method has restarted. When a saved state is read, it is called with an empty text once it
  // is known which bodies sleep, before the method reads its own state. Must be set before the
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
  // All bodies wake.
  void restart(double time, std::span<const double> y) override;
  [[nodiscard]] bool transfer(StateArchive& archive) override;
  std::string decision() const override { return integrator_->decision(); }

  // The dynamics of the awake bodies, and the state that goes with it.
  Dynamics& dynamics() const { return awake_ ? awake_->dynamics : whole_; }
  std::span<const double> awake_state() const { return integrator_->state(); }
  // Takes the part of awake bodies from a state of the whole scene.
  std::vector<double> awake_part(std::span<const double> y) const;
  // Adds the energies of sleeping bodies to those of the awake ones.
  Energies with_asleep(const Energies& awake) const;
  // Returns the smaller of two smallest gaps (m): that of the awake bodies, which is passed, and
  // that of the sleeping ones; nothing if there is neither.
  std::optional<double> with_asleep(std::optional<double> smallest_gap) const;
  int sleeping_bodies() const;
  // Returns a failure of the awake bodies with its particle's number in the whole scene.
  Failure in_whole(Failure failure) const;

 private:
  struct Awake {
    Awake(const Scene& whole, std::span<const char> asleep, std::span<const Vec3> position,
          Dynamics& of_whole)
        : part(whole, asleep, position), dynamics(part.scene(), of_whole.statistics()) {
      dynamics.share_creases(of_whole);
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
  std::vector<char> has_moving_pin_;  // by dynamic body
  RestWatch rest_;
  std::vector<char> asleep_;      // by dynamic body
  std::vector<int> island_;       // by dynamic body: the first body it fell asleep with
  std::vector<Vec3> built_at_;    // m, of dynamic particles when awake_ was built
  std::unique_ptr<Awake> awake_;  // null if all bodies are awake
  std::unique_ptr<Integrator> integrator_;
  std::vector<double> state_;         // of the whole; kept only while bodies sleep
  Energies frozen_;                   // of sleeping bodies
  std::optional<double> frozen_gap_;  // m, the smallest of sleeping bodies
  IntegratorCounts earlier_;          // of earlier integrators
};

}  // namespace weft::sim
