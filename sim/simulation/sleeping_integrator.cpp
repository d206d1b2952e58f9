#include "sim/simulation/sleeping_integrator.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"
#include "sim/scene/sliding_supports.h"

namespace weft::sim {

namespace {

// Smallest fraction of the awake vertices that may fall asleep together. With fewer, the short
// steps after the restart of the method would cost more than sleep saves.
constexpr double least_share = 0.1;

std::vector<char> find_moving_pins(const Scene& scene) {
  std::vector<char> has_moving_pin(scene.dynamic_bodies, 0);
  for (const PrescribedMotion& held : scene.prescribed) {
    if (!held.moves || held.particles.empty() || held.particles.front() >= scene.dynamic_particles)
      continue;
    has_moving_pin[scene.body_index_of_particle(held.particles.front())] = 1;
  }
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const auto& supports = scene.bodies[b].supports;
    if (supports && supports->any_moves()) has_moving_pin[b] = 1;
  }
  for (const TimedPin& pin : scene.timed_pins) {
    const double last = std::max(pin.source->hold_time, pin.source->release_time.value_or(0));
    if (last >= scene.pins_change_at) has_moving_pin[pin.body] = 1;
  }
  const auto add_joint = [&](const auto& joint) {
    const int body = scene.case_order[joint.body], other = scene.case_order[joint.to];
    if (scene.bodies[body].dynamic && scene.bodies[other].moves && !scene.bodies[other].dynamic)
      has_moving_pin[body] = 1;
    if (scene.bodies[other].dynamic && scene.bodies[body].moves && !scene.bodies[body].dynamic)
      has_moving_pin[other] = 1;
  };
  for (const Tie& tie : scene.ties) add_joint(tie);
  for (const Seam& seam : scene.seams) add_joint(seam);
  return has_moving_pin;
}

// Returns the lowest body in the set of a body (union-find). set[i] is a body in the set of i, with
// set[i] <= i. The lowest body of a set refers to itself.
int root_of(std::vector<int>& set, int body) {
  while (set[body] != body) body = set[body] = set[set[body]];
  return body;
}

Energies no_energies(const Dynamics& dynamics) {
  Energies none;
  for (const std::string& name : dynamics.force_names()) none.elastic.emplace_back(name, 0.0);
  return none;
}

// Returns a + factor * b. Forces that only `a` has keep their energies.
Energies sum_of(Energies a, double factor, const Energies& b) {
  a.kinetic += factor * b.kinetic;
  a.gravitational += factor * b.gravitational;
  a.contact += factor * b.contact;
  if (b.dissipated) a.dissipated = a.dissipated.value_or(0) + factor * *b.dissipated;
  for (auto& [name, value] : a.elastic) {
    for (const auto& [other, more] : b.elastic) {
      if (other == name) value += factor * more;
    }
  }
  return a;
}

}  // namespace

bool may_sleep(const Scene& scene) {
  const TimeCase& time = scene.source.time;
  return time.sleep && scene.dynamic_bodies >= 2 && !traits_of(time.method).finds_equilibria() &&
         scene.source.particles.empty();
}

SleepingIntegrator::SleepingIntegrator(const Scene& scene, Dynamics& whole)
    : scene_(scene),
      whole_(whole),
      moving_boxes_(scene),
      curves_(scene.source),
      has_moving_pin_(find_moving_pins(scene)),
      rest_(scene, 0, whole.initial_state()),
      asleep_(scene.dynamic_bodies, 0),
      island_(scene.dynamic_bodies, 0),
      frozen_(no_energies(whole)) {
  build();
}

std::optional<Failure> SleepingIntegrator::step() {
  if (rest_.is_due(time())) fall_asleep();
  const double start = time();
  whole_.begin_step(start);
  for (;;) {
    // Recording a frame evaluates contact, which marks touched bodies. These marks are removed,
    // because frames must not change the steps.
    if (Contact* contact = dynamics().contact()) contact->forget_touched();
    auto failure = integrator_->step();
    const bool is_stopped = failure && (failure->kind == Failure::Kind::interrupted ||
                                        failure->kind == Failure::Kind::cpu_limit);
    const std::vector<int> touched = is_stopped ? std::vector<int>{} : touched_islands(start);
    if (!touched.empty()) {
      wake(start, touched);
      if (!failure) --earlier_.steps;  // a step that is taken back does not count
      continue;
    }
    if (failure) return in_whole(std::move(*failure));
    if (awake_) awake_->part.scatter(integrator_->state(), state_);
    return std::nullopt;
  }
}

std::optional<Failure> SleepingIntegrator::state_at(double time, std::span<double> y) const {
  if (!awake_) return integrator_->state_at(time, y);
  std::vector<double> part(awake_->dynamics.state_size());
  if (auto failure = integrator_->state_at(time, part)) return in_whole(std::move(*failure));
  std::copy(state_.begin(), state_.end(), y.begin());
  awake_->part.scatter(part, y);
  return std::nullopt;
}

void SleepingIntegrator::restart(double time, std::span<const double> y) {
  if (awake_) {
    std::ranges::fill(asleep_, 0);
    earlier_ += integrator_->counts();
    build();
  }
  integrator_->restart(time, y);
  rest_.begin(time, y);
}

void SleepingIntegrator::transfer(StateArchive& archive) {
  archive(asleep_, island_, built_at_, state_, frozen_.kinetic, frozen_.gravitational,
          frozen_.contact, frozen_.dissipated, frozen_gap_, earlier_);
  for (auto& [name, energy] : frozen_.elastic) archive(energy);
  rest_.transfer(archive);
  if (archive.reads()) {
    build();
    after_change_({});
  }
  integrator_->transfer(archive);
}

std::vector<double> SleepingIntegrator::awake_part(std::span<const double> y) const {
  if (!awake_) return {y.begin(), y.end()};
  std::vector<double> part(awake_->dynamics.state_size());
  awake_->part.gather(y, part);
  return part;
}

Energies SleepingIntegrator::with_asleep(const Energies& awake) const {
  return awake_ ? sum_of(frozen_, 1, awake) : awake;
}

std::optional<double> SleepingIntegrator::with_asleep(std::optional<double> smallest_gap) const {
  if (!awake_ || !frozen_gap_) return smallest_gap;
  return std::min(*frozen_gap_, smallest_gap.value_or(*frozen_gap_));
}

int SleepingIntegrator::sleeping_bodies() const {
  return static_cast<int>(std::ranges::count(asleep_, 1));
}

// Returns the island of each dynamic body, named by its lowest body. Ties, seams and contacts of
// the last force evaluation connect the bodies of an island, directly or through other bodies.
std::vector<int> SleepingIntegrator::find_islands() const {
  std::vector<int> set(scene_.dynamic_bodies);
  std::iota(set.begin(), set.end(), 0);
  const Contact* contact = dynamics().contact();
  const Scene& awake = dynamics().scene();
  const auto root = [&](int point) {
    const int body = awake.body_index_of_point(point);
    return root_of(set, awake_ ? awake_->part.whole_body(body) : body);
  };
  if (contact != nullptr) {
    for (const ContactPair& pair : contact->pairs()) {
      if (std::max(pair.nodes[0], pair.nodes[3]) >= awake.dynamic_points) continue;
      const int a = root(pair.nodes[0]), b = root(pair.nodes[3]);
      set[std::max(a, b)] = std::min(a, b);
    }
  }
  const auto join = [&](const auto& joint) {
    const int body = scene_.case_order[joint.body], other = scene_.case_order[joint.to];
    if (std::max(body, other) >= scene_.dynamic_bodies) return;
    const int a = root_of(set, body), b = root_of(set, other);
    set[std::max(a, b)] = std::min(a, b);
  };
  for (const Tie& tie : scene_.ties) join(tie);
  for (const Seam& seam : scene_.seams) join(seam);
  for (int body = 0; body < scene_.dynamic_bodies; ++body) set[body] = root_of(set, body);
  return set;
}

// Marks the bodies that already sleep, and the bodies of islands that may fall asleep as a whole.
std::vector<char> SleepingIntegrator::bodies_that_may_sleep(const std::vector<int>& islands) const {
  std::vector<char> may_sleep(scene_.dynamic_bodies, 1);
  for (int body = 0; body < scene_.dynamic_bodies; ++body) {
    if (asleep_[body] != 0) continue;
    const bool may = rest_.is_at_rest(body) && has_moving_pin_[body] == 0 &&
                     !is_driven(body, time(), time() + RestWatch::window) &&
                     !moving_boxes_.may_reach(box_of(body), scene_.bodies[body].thickness, time(),
                                              time() + RestWatch::window);
    if (!may) may_sleep[islands[body]] = 0;
  }
  for (int body = 0; body < scene_.dynamic_bodies; ++body) {
    if (asleep_[body] == 0) may_sleep[body] = may_sleep[islands[body]];
  }
  return may_sleep;
}

void SleepingIntegrator::fall_asleep() {
  rest_.look(time(), state(), asleep_);
  const auto is_resting = [&](int body) {
    return asleep_[body] == 0 && rest_.is_at_rest(body) && has_moving_pin_[body] == 0;
  };
  bool rests = false;
  for (int body = 0; body < scene_.dynamic_bodies; ++body) rests |= is_resting(body);
  if (!rests) return;
  const std::vector<int> islands = find_islands();
  std::vector<char> next = bodies_that_may_sleep(islands);
  // One island stays awake, even if all bodies are at rest.
  if (std::ranges::all_of(next, [](char asleep) { return asleep != 0; })) {
    const auto first = std::ranges::find(asleep_, 0) - asleep_.begin();
    for (int body = 0; body < scene_.dynamic_bodies; ++body) {
      if (asleep_[body] == 0 && islands[body] == islands[first]) next[body] = 0;
    }
  }
  std::vector<int> falling;
  int vertices = 0;
  for (int body = 0; body < scene_.dynamic_bodies; ++body) {
    if (next[body] == asleep_[body]) continue;
    falling.push_back(body);
    vertices += scene_.bodies[body].particle_count();
  }
  if (vertices < least_share * dynamics().scene().dynamic_particles || falling.empty()) return;
  for (const int body : falling) island_[body] = islands[body];
  asleep_ = next;
  change(time(), falling, "sleep");
}

// True if a curve that can set the body in motion changes between `from` and `to` (s), or one of
// its seams is closing. A jump within time.minimum_step before `from` counts as well. A jump at
// `to`, or less than half of time.minimum_step before it, does not count.
bool SleepingIntegrator::is_driven(int body, double from, double to) const {
  const MaterialCase* material = scene_.bodies[body].material;
  const double nearby = scene_.source.time.minimum_step;
  return curves_.may_move(material->name, from - nearby, to - 0.5 * nearby) ||
         closes_after(scene_, body, from);
}

// Returns the islands that must wake because of the step from `from` to time(), whether the step
// succeeded or failed. An awake body touched them, an obstacle moved near them, or a curve that
// acts on them changed.
std::vector<int> SleepingIntegrator::touched_islands(double from) const {
  std::vector<int> touched;
  if (!awake_) return touched;
  const Contact* contact = awake_->dynamics.contact();
  const Scene& awake = awake_->part.scene();
  for (int b = awake.dynamic_bodies; b < scene_.dynamic_bodies; ++b) {
    const int body = awake_->part.whole_body(b);
    if ((contact != nullptr && contact->touched()[b] != 0) || is_driven(body, from, time()) ||
        moving_boxes_.may_reach(box_of(body), awake.bodies[b].thickness, from, time()))
      touched.push_back(island_[body]);
  }
  return touched;
}

void SleepingIntegrator::wake(double now, const std::vector<int>& islands) {
  std::vector<int> waking;
  for (int body = 0; body < scene_.dynamic_bodies; ++body) {
    if (asleep_[body] == 0 || std::ranges::find(islands, island_[body]) == islands.end()) continue;
    asleep_[body] = 0;
    waking.push_back(body);
  }
  change(now, waking, "wake");
}

// Restarts the method at `now` (s), the time of state_. `bodies` have just fallen asleep or woken;
// `event` is "sleep" or "wake".
void SleepingIntegrator::change(double now, const std::vector<int>& bodies, const char* event) {
  if (!awake_) state_.assign(integrator_->state().begin(), integrator_->state().end());
  auto* const velocity = reinterpret_cast<Vec3*>(state_.data()) + scene_.dynamic_particles;
  for (const int body : bodies) {
    if (asleep_[body] == 0) {
      rest_.begin_window(body, now, state_);
    } else {
      std::fill_n(velocity + scene_.bodies[body].first_particle,
                  scene_.bodies[body].particle_count(), Vec3::Zero());
    }
  }
  const std::span<const Vec3> position = StateView::of(state_).position;
  built_at_.assign(position.begin(), position.end());
  earlier_ += integrator_->counts();
  build();
  integrator_->restart(now, awake_part(state_));
  find_frozen(now);
  after_change_(described(bodies, event) + " at t = " + rounded_text(now) + " s");
}

// Builds the dynamics and the integrator of the awake bodies.
void SleepingIntegrator::build() {
  integrator_.reset();
  awake_.reset();
  if (sleeping_bodies() > 0) awake_ = std::make_unique<Awake>(scene_, asleep_, built_at_, whole_);
  integrator_ = make_integrator(dynamics().scene(), dynamics());
  integrator_->set_reason_to_stop([this] { return reason_to_stop(); });
}

// Computes the energies of sleeping bodies and the smallest gap at them.
void SleepingIntegrator::find_frozen(double now) {
  frozen_gap_.reset();
  if (!awake_) return;
  frozen_ = whole_.energies(now, state_);
  if (const Contact* contact = whole_.contact()) {
    for (const ContactPair& pair : contact->pairs()) {
      // At least one of the two bodies is dynamic. The points of that body have the lower indices.
      const int body = scene_.body_index_of_point(std::min(pair.nodes[0], pair.nodes[3]));
      if (asleep_[body] != 0) frozen_gap_ = std::min(pair.gap, frozen_gap_.value_or(pair.gap));
    }
  }
  frozen_ = sum_of(frozen_, -1, awake_->dynamics.energies(now, integrator_->state()));
}

// Returns the present box (m) around a body.
Eigen::AlignedBox3d SleepingIntegrator::box_of(int body) const {
  Eigen::AlignedBox3d box;
  const SceneBody& of = scene_.bodies[body];
  for (const Vec3& point :
       StateView::of(state()).position.subspan(of.first_particle, of.particle_count()))
    box.extend(point);
  return box;
}

Failure SleepingIntegrator::in_whole(Failure failure) const {
  if (awake_ && failure.particle >= 0)
    failure.particle = awake_->part.whole_particle(failure.particle);
  return failure;
}

std::string SleepingIntegrator::described(const std::vector<int>& bodies,
                                          const std::string& event) const {
  constexpr std::size_t most_names = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(bodies.size(), most_names); ++i)
    names += (i == 0 ? "" : ", ") + in_quotes(scene_.bodies[bodies[i]].name);
  if (bodies.size() == 1) return "body " + names + " " + event + "s";
  if (bodies.size() > most_names)
    names += " and " + std::to_string(bodies.size() - most_names) + " more";
  return std::to_string(bodies.size()) + " bodies " + event + " (" + names + ")";
}

}  // namespace weft::sim
