#include "sim/simulation/timed_pins_integrator.h"

#include <algorithm>

#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

std::string described(const std::vector<char>& before, const std::vector<char>& after,
                      double time) {
  int released = 0, taken = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    released += static_cast<int>(before[i] != 0 && after[i] == 0);
    taken += static_cast<int>(before[i] == 0 && after[i] != 0);
  }
  return "vertices that pins let go at t = " + rounded_text(time) +
         " s: " + std::to_string(released) + ", and take hold of: " + std::to_string(taken);
}

}  // namespace

TimedPinsIntegrator::TimedPinsIntegrator(const Scene& scene, Dynamics& whole)
    : scene_(scene),
      whole_(whole),
      holds_(scene.first_holds),
      built_at_(scene.initial_position.begin(),
                scene.initial_position.begin() + scene.dynamic_particles) {
  build();
  copy_state();
}

// A change within the shortest step counts as reached, as for MotionLimits.
bool TimedPinsIntegrator::is_change_due() const {
  return time() + scene_.source.time.minimum_step >= stage_->scene.pins_change_at;
}

std::optional<Failure> TimedPinsIntegrator::step() {
  while (is_change_due()) change();
  whole_.begin_step(time());
  if (auto failure = stage_->integrator->step()) return failure;
  copy_state();
  return std::nullopt;
}

void TimedPinsIntegrator::change() {
  const double now = time();
  const std::vector<char> before = stage_->scene.pinned;
  std::vector<double> y(state().begin(), state().end());
  place_pinned(stage_->scene, now, true, y);
  event_ = stage_->scene.pins_change_at;
  const std::span<const Vec3> position = StateView::of(y).position;
  holds_ = find_holds(scene_, event_, now, position, holds_);
  built_at_.assign(position.begin(), position.end());
  earlier_ += stage_->integrator->counts();
  build();
  restart(now, y);
  after_change_(described(before, stage_->scene.pinned, now));
}

// Makes what simulates the scene from event_ on.
void TimedPinsIntegrator::build() {
  stage_.reset();
  stage_ = std::make_unique<Stage>(hold_timed_pins(scene_, holds_, event_, built_at_),
                                   whole_.statistics());
  if (may_sleep(stage_->scene)) {
    auto made = std::make_unique<SleepingIntegrator>(stage_->scene, stage_->dynamics);
    stage_->sleeping = made.get();
    made->set_after_change([this](const std::string& text) { after_change_(text); });
    stage_->integrator = std::move(made);
  } else {
    stage_->integrator = make_integrator(stage_->scene, stage_->dynamics);
  }
  stage_->integrator->set_reason_to_stop([this] { return reason_to_stop(); });
}

// Methods hold pins that move to their tolerances only.
void TimedPinsIntegrator::copy_state() {
  state_.clear();
  if (!stage_->dynamics.pins_move()) return;
  state_.assign(stage_->integrator->state().begin(), stage_->integrator->state().end());
  place_pinned(stage_->scene, time(), false, state_);
}

std::optional<Failure> TimedPinsIntegrator::state_at(double time, std::span<double> y) const {
  if (auto failure = stage_->integrator->state_at(time, y)) return failure;
  // Interpolation rounds the places of pins at rest, too.
  place_pinned(stage_->scene, time, false, y);
  return std::nullopt;
}

void TimedPinsIntegrator::restart(double time, std::span<const double> y) {
  std::vector<double> placed(y.begin(), y.end());
  place_pinned(stage_->scene, time, false, placed);
  stage_->integrator->restart(time, placed);
  copy_state();
}

bool TimedPinsIntegrator::transfer(StateArchive& archive) {
  std::size_t count = holds_.size();
  archive(event_, built_at_, earlier_, count);
  holds_.resize(count);
  for (TimedHold& hold : holds_) archive(hold.pin, hold.particles, hold.start, hold.centre);
  if (archive.reads()) {
    build();
    after_change_({});
  }
  if (!stage_->integrator->transfer(archive)) return false;
  copy_state();
  return true;
}

}  // namespace weft::sim
