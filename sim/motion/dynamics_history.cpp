// Creases and anchors advance with accepted steps alone.
#include "sim/motion/dynamics.h"

namespace weft::sim {

void Dynamics::share_history(const Dynamics& other) {
  if (other.creases_) {
    creases_ = other.creases_;
    for (const auto& force : forces_) force->use_creases(*creases_);
  }
  if (other.anchors_ && contact_) {
    anchors_ = other.anchors_;
    contact_->use_anchors(*anchors_);
  }
}

void Dynamics::accept_history(double time, std::span<const double> y) {
  if (creases_) {
    const Kinematics state = kinematics(time, y);
    creases_->begin_accept(time);
    for (const auto& force : forces_) force->advance_creases(state, *creases_, threads_);
    creases_->end_accept();
  }
  if (anchors_) accept_anchors(time, y);
}

// Contact is evaluated with the anchors so far. A state that contact refuses keeps them.
void Dynamics::accept_anchors(double time, std::span<const double> y) {
  set_time(time);
  expand(time, y, position_, velocity_);
  const bool is_refused = evaluate_contact(time).has_value();
  anchors_->begin_accept(time);
  if (!is_refused) contact_->advance_anchors(anchors_->at_end());
  anchors_->end_accept();
}

CreaseHistory::Creases Dynamics::creases_of(double time, std::span<const double> y, int body) {
  if (!creases_) return {};
  const Kinematics state = kinematics(time, y);
  CreaseHistory advanced = *creases_;
  for (const auto& force : forces_) force->advance_creases(state, advanced, threads_);
  const auto creases = advanced.advanced(scene_.case_index(body));
  return {creases.begin(), creases.end()};
}

void Dynamics::restart_history(double time, std::span<const double> y) {
  const bool creases = creases_ && creases_->take_back(time);
  const bool anchors = anchors_ && anchors_->take_back(time);
  if (creases || anchors) accept_history(time, y);
}

void Dynamics::transfer_history(StateArchive& archive) {
  if (creases_) creases_->transfer(archive);
  if (!anchors_) return;
  anchors_->transfer(archive, [&](Anchors& anchors) { transfer(archive, anchors, scene_); });
}

// Selects the history from which forces at `time` (s) follow.
void Dynamics::choose_history(double time) {
  if (creases_) creases_->choose(time);
  if (anchors_) anchors_->choose(time);
}

}  // namespace weft::sim
