// What the methods have in common that go from one state to the next: steps on a grid or of chosen
// length, shortened until they succeed and keep surfaces apart; states in between.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "sim/integrator/integrator.h"
#include "sim/integrator/motion_limits.h"

namespace weft::sim {

// With `time.step`, times are its multiples (of `static`: of the time between frames); a step that
// fails is taken in shorter parts, halved until they succeed, and doubled again up to the next
// multiple: after one success at first, after two, four .. 16 where the double fails again.
// Without, the method says how long the next step should be. Where pins or obstacles move, steps
// of either kind end earlier (motion_limits.h), and those of a grid go on from there to its next
// time. More than 100 cuts to keep surfaces
// apart in 200 steps that were taken end the run.
class OneStepIntegrator : public Integrator {
 public:
  OneStepIntegrator(const Scene& scene, Dynamics& dynamics);

  [[nodiscard]] std::optional<std::string> step() final;
  double time() const final { return time_; }
  double last_step() const final { return time_ - previous_time_; }
  std::span<const double> state() const final { return state_; }
  // Cubic in the positions and their rates at both ends, and its rate for the velocities.
  [[nodiscard]] std::optional<std::string> state_at(double time,
                                                    std::span<double> y) const override;
  IntegratorCounts counts() const override { return counts_; }

 protected:
  enum class Trouble { none, not_converged, surfaces, not_finite, error_too_large, unstable };
  // Tries a step from time() and state() to `end` and leaves it in `y`. A method that has no fixed
  // step may end elsewhere, and says where. On trouble, may name what stands in the way by
  // set_fault() or set_place().
  virtual Trouble attempt(double& end, std::span<double> y) = 0;
  // The method has checked the way it took, which need not be straight.
  virtual bool checks_its_own_path() const { return false; }
  // A prescribed motion starts, stops or passes a keyframe at time(): earlier slopes say nothing
  // about what follows, and where its velocity jumps, nothing about the state either.
  virtual void pass_event(bool /*jumps*/) {}
  // Said before the first step; a reason not to begin.
  virtual std::optional<std::string> refusal() { return std::nullopt; }

  bool is_fixed() const { return step_.has_value(); }
  // Without a fixed step: the length of the next step, or of the next try.
  void propose(double h) { size_ = h; }
  void set_fault(const std::optional<ContactFault>& fault) { fault_ = fault; }
  const std::optional<ContactFault>& fault() const { return fault_; }
  void set_place(int particle) { place_ = particle; }
  // Between the parts of a long try, which then ends with any trouble: step() fails with the reason
  // to stop.
  bool should_stop() {
    if (!stopped_) stopped_ = reason_to_stop();
    return stopped_.has_value();
  }

  // The latest end of a step that is to end at `wanted`, where motions limit it; nothing, and a
  // reason that step() fails with, where it cannot be short enough.
  std::optional<double> latest_end(double wanted);
  bool motions_limit_steps() const { return motion_limits_.apply(); }

  const Scene& scene() const { return scene_; }
  Dynamics& dynamics() const { return dynamics_; }
  // All particles, at time(); empty without contact, where no path is checked.
  const std::vector<Vec3>& positions() const { return position_; }

 private:
  double grid_time() const;
  double wanted_time() const;
  std::optional<double> next_time();
  Trouble check_path(double time);
  void accept(double time);
  void count(Trouble trouble);
  std::string failure(Trouble trouble) const;
  std::optional<std::string> too_many_vetoes();

  const Scene& scene_;
  Dynamics& dynamics_;
  MotionLimits motion_limits_;
  std::optional<double> step_;  // s, of the grid
  double time_ = 0, previous_time_ = 0;
  double size_ = 0;                                                      // s, of the next try
  double longest_after_veto_ = std::numeric_limits<double>::infinity();  // s, of chosen steps
  std::int64_t completed_steps_ = 0;                                     // of the grid
  int successes_ = 0, patience_ = 1;  // of a length, and how many before it is doubled
  // The other state is that before the last step and, from its first try on, the end of the next.
  std::vector<double> state_, other_state_;
  bool has_previous_ = false;
  // Positions (all particles) that go with them, with contact; `interpolated_` is scratch.
  std::vector<Vec3> position_, previous_position_, trial_position_;
  mutable std::vector<Vec3> interpolated_, scratch_velocity_;
  IntegratorCounts counts_;
  std::optional<ContactFault> fault_, last_veto_;
  std::int64_t vetoes_before_window_ = 0;
  double window_start_ = 0;    // s
  double window_allowed_ = 0;  // s: what its steps might have advanced within the motions' limits
  double allowed_ = 0;         // s, of the step in hand
  int place_ = -1;
  std::optional<std::string> stopped_;  // why this step is to be left
};

}  // namespace weft::sim
