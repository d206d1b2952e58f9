#include "sim/simulation/changing_scene_integrator.h"

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

Scene scene_without(Scene scene, const std::vector<int>& broken) {
  std::erase_if(scene.ties, [&](const Tie& tie) {
    return std::ranges::find(broken, tie.number) != broken.end();
  });
  return scene;
}

}  // namespace

bool changes_in_time(const Scene& scene) {
  return !scene.timed_pins.empty() || has_breakable_ties(scene);
}

ChangingSceneIntegrator::Stage::Stage(Scene now, Dynamics& whole)
    : scene(std::move(now)), dynamics(scene, whole.statistics()) {
  dynamics.share_history(whole);
  for (const Tie& tie : scene.ties) {
    if (tie.source->break_force) breakable.emplace_back(scene, std::span(&tie, 1));
  }
}

ChangingSceneIntegrator::ChangingSceneIntegrator(const Scene& scene, Dynamics& whole)
    : scene_(scene),
      whole_(whole),
      holds_(scene.first_holds),
      built_at_(scene.initial_position.begin(),
                scene.initial_position.begin() + scene.dynamic_particles) {
  build();
  copy_state();
}

// A change within time.minimum_step counts as reached.
bool ChangingSceneIntegrator::is_change_due() const {
  return time() + scene_.source.time.minimum_step >= stage_->scene.pins_change_at;
}

std::optional<Failure> ChangingSceneIntegrator::step() {
  if (breaks_at_) break_ties();
  while (is_change_due()) change_pins();
  before_ = time();
  whole_.begin_step(before_);
  if (auto failure = stage_->integrator->step()) return failure;
  copy_state();
  if (overload(time(), state()) > 0) end_step_at(breaking_time());
  return std::nullopt;
}

void ChangingSceneIntegrator::change_pins() {
  const double now = time();
  const std::vector<char> before = stage_->scene.pinned;
  std::vector<double> y(state().begin(), state().end());
  place_pinned(stage_->scene, now, true, y);
  event_ = stage_->scene.pins_change_at;
  holds_ = find_holds(scene_, event_, now, StateView::of(y).position, holds_);
  begin_stage(now, y);
  after_change_(described(before, stage_->scene.pinned, now));
}

// Returns the largest load / break_force - 1 of the ties that may break, or -1 without such ties.
double ChangingSceneIntegrator::overload(double time, std::span<const double> y) const {
  double most = -1;
  auto springs = stage_->breakable.begin();
  for (const Tie& tie : stage_->scene.ties) {
    if (!tie.source->break_force) continue;
    springs->set_time({time, time});
    most = std::max(most, springs->load(StateView::of(y).position) / *tie.source->break_force - 1);
    ++springs;
  }
  return most;
}

// Returns a time (s) within the last step at which the load of a tie exceeds its break_force.
// Bisection finds this time to within time.minimum_step.
double ChangingSceneIntegrator::breaking_time() const {
  double holds = before_, breaks = time();
  std::vector<double> y(whole_.state_size());
  while (breaks - holds > scene_.source.time.minimum_step) {
    const double middle = 0.5 * (holds + breaks);
    // If no interpolated state keeps surfaces apart, the tie breaks at the end of the step.
    if (state_at(middle, y)) return time();
    (overload(middle, y) > 0 ? breaks : holds) = middle;
  }
  return breaks;
}

// Ends the last step at the time `breaking` (s) of breaking_time(). Ties break when the next step
// begins.
void ChangingSceneIntegrator::end_step_at(double breaking) {
  if (breaking < time()) {
    std::vector<double> y(whole_.state_size());
    // state_at() cannot fail, because breaking_time() has tried this state.
    if (state_at(breaking, y)) return;
    state_ = std::move(y);
  }
  breaks_at_ = breaking;
  find_awake_state();
}

void ChangingSceneIntegrator::find_awake_state() {
  if (is_shortened() && stage_->sleeping != nullptr)
    awake_state_ = stage_->sleeping->awake_part(state_);
}

// Continues from the end of the last step without the ties that break there.
void ChangingSceneIntegrator::break_ties() {
  const double now = time();
  const std::vector<double> y(state().begin(), state().end());
  breaks_at_.reset();
  std::string names;
  auto springs = stage_->breakable.begin();
  for (const Tie& tie : stage_->scene.ties) {
    if (!tie.source->break_force) continue;
    springs->set_time({now, now});
    if (springs->load(StateView::of(y).position) >= *tie.source->break_force) {
      broken_.push_back(tie.number);
      names += (names.empty() ? "" : ", ") + in_quotes(tie.source->body) + " to " +
               in_quotes(tie.source->to);
    }
    ++springs;
  }
  begin_stage(now, y);
  after_change_("tie breaks at t = " + rounded_text(now) + " s: " + names);
}

// Starts a new stage at `now` (s), with the present pins and ties and the state `y`.
void ChangingSceneIntegrator::begin_stage(double now, std::span<const double> y) {
  const std::span<const Vec3> position = StateView::of(y).position;
  built_at_.assign(position.begin(), position.end());
  earlier_ += stage_->integrator->counts();
  build();
  restart(now, y);
}

// Builds the scene, the dynamics and the integrator of a stage from the holds since event_.
void ChangingSceneIntegrator::build() {
  stage_.reset();
  stage_ = std::make_unique<Stage>(
      scene_without(hold_timed_pins(scene_, holds_, event_, built_at_), broken_), whole_);
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

// Copies the state and places moving pins exactly. Methods compute the positions of these pins only
// within tolerances.
void ChangingSceneIntegrator::copy_state() {
  state_.clear();
  if (!stage_->dynamics.pins_move()) return;
  state_.assign(stage_->integrator->state().begin(), stage_->integrator->state().end());
  place_pinned(stage_->scene, time(), false, state_);
}

std::optional<Failure> ChangingSceneIntegrator::state_at(double time, std::span<double> y) const {
  if (auto failure = stage_->integrator->state_at(time, y)) return failure;
  // Interpolation rounds the positions of pins at rest, too.
  place_pinned(stage_->scene, time, false, y);
  return std::nullopt;
}

void ChangingSceneIntegrator::restart(double time, std::span<const double> y) {
  if (breaks_at_ && time >= *breaks_at_) break_ties();
  breaks_at_.reset();
  std::vector<double> placed(y.begin(), y.end());
  place_pinned(stage_->scene, time, false, placed);
  stage_->integrator->restart(time, placed);
  copy_state();
}

void ChangingSceneIntegrator::transfer(StateArchive& archive) {
  std::size_t count = holds_.size();
  archive(event_, built_at_, earlier_, broken_, before_, breaks_at_, state_, count);
  holds_.resize(count);
  for (TimedHold& hold : holds_) {
    std::size_t clamped = hold.clamped.size();
    archive(hold.pin, hold.particles, hold.start, hold.centre, clamped);
    hold.clamped.resize(clamped);
    for (ClampedEdge& edge : hold.clamped) archive(edge.triangle, edge.edge, edge.ghost);
  }
  if (archive.reads()) {
    build();
    after_change_({});
  }
  stage_->integrator->transfer(archive);
  if (!is_shortened()) copy_state();
  find_awake_state();
}

}  // namespace weft::sim
