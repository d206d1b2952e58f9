#include "sim/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/base/fingerprint.h"
#include "sim/base/state_archive.h"
#include "sim/case/case_text.h"
#include "sim/case/case_writer.h"
#include "sim/case/frame_times.h"
#include "sim/case/time_methods.h"
#include "sim/integrator/integrator.h"
#include "sim/motion/energy_watch.h"
#include "sim/simulation/changing_scene_integrator.h"
#include "sim/simulation/checkpoint_schedule.h"
#include "sim/simulation/sleeping_integrator.h"

namespace weft::sim {

namespace {

// Number of steps between two checks of their energies, for explicit methods and for those whose
// steps SUNDIALS chooses by their errors. A check of every step would cost too much. Energy that an
// explicit step adds by mistake remains visible in later steps, and error control leaves little.
constexpr int steps_between_looks = 8;

// First bytes of a saved state. The last digit is the version of its layout.
constexpr std::string_view save_mark = "weft state 4, version " WEFT_VERSION;

// Returns the fingerprint of what the files of a case give: another shape gives another one.
std::uint64_t fingerprint_of(const Scene& scene) {
  Fingerprint fingerprint;
  fingerprint.add_list(scene.initial_position);
  fingerprint.add_list(scene.mass);
  fingerprint.add_list(scene.pinned);
  return fingerprint.value();
}

}  // namespace

struct Simulation::Implementation {
  Implementation(const Scene& scene_, std::unique_ptr<const Scene> owned_)
      : owned(std::move(owned_)),
        scene(scene_),
        frame_times(scene_.source),
        schedule(scene_.source) {
    make_parts();
    decision = integrator->decision();
  }

  // Makes the dynamics, the integrator and the watch, which then are those of the start.
  void make_parts();
  void make_own_integrator();
  // Returns the dynamics that is being integrated, without sleeping bodies and with the pins and
  // ties of the last step. awake_state() is its state.
  Dynamics& awake() {
    if (sleeping != nullptr) return sleeping->dynamics();
    return changing != nullptr ? changing->dynamics() : *dynamics;
  }
  std::span<const double> awake_state() const {
    if (changing != nullptr) return changing->awake_state();
    return sleeping != nullptr ? sleeping->awake_state() : integrator->state();
  }
  // Returns the energies of awake() at the end of the last step.
  Energies energies_of_awake() {
    const double time = integrator->time();
    const bool is_within = changing != nullptr && changing->is_shortened();
    return is_within ? awake().energies(time, awake_state())
                     : awake().energies_at_last_rate(time, awake_state());
  }
  Energies with_asleep(const Energies& of_awake) const {
    return sleeping != nullptr ? sleeping->with_asleep(of_awake)
                               : with_spins(of_awake, integrator->time());
  }
  Energies with_spins(Energies energies_of_state, double time) const {
    energies_of_state.kinetic += integrator->spin_energy_at(time);
    return energies_of_state;
  }

  std::optional<Failure> step();
  std::optional<Failure> judge_step();
  bool is_look_due() const;
  void note_decisions();
  void decide(const std::string& text) {
    for (StepObserver* observer : observers) observer->after_decision(text);
  }
  int index_of(std::string_view body) const;
  void expand() const;
  std::vector<Vec3> of_body(std::string_view body, const std::vector<Vec3>& all) const;
  void transfer(StateArchive& archive);
  std::string bytes();
  void restore(std::string_view bytes);

  std::unique_ptr<const Scene> owned;  // null if the caller owns the scene
  const Scene& scene;
  FrameTimes frame_times;
  CheckpointSchedule schedule;
  Statistics statistics;
  std::optional<Dynamics> dynamics;  // never empty; make_parts() replaces the object in its place
  std::unique_ptr<Integrator> integrator;
  // The integrator that lets bodies sleep: `integrator` or the integrator within `changing`. Null
  // if bodies cannot sleep.
  SleepingIntegrator* sleeping = nullptr;
  // Equal to `integrator` if the scene changes in time, else null.
  ChangingSceneIntegrator* changing = nullptr;
  std::optional<EnergyWatch> watch;
  int steps_since_look = 0;
  double last_look = 0;  // time of the last check of the energy (s)
  std::string decision;
  std::string compute;
  std::size_t contact_pairs = 0;       // pairs in reach in the last force evaluation
  std::optional<double> smallest_gap;  // smallest gap of these pairs (m)
  std::vector<StepObserver*> observers;
  std::function<std::optional<Failure>()> reason_to_stop;
  // The interpolated state that advance() has reached within the last step. Empty if the state is
  // that at the end of the step.
  std::vector<double> inner_state;
  double inner_time = 0;
  mutable std::optional<Energies> energies;  // energies after the last step; empty until computed
  mutable std::vector<Vec3> position, velocity;
  mutable bool is_expanded = false;
};

void Simulation::Implementation::make_parts() {
  watch.reset();
  integrator.reset();
  sleeping = nullptr;
  changing = nullptr;
  dynamics.emplace(scene, statistics);
  make_own_integrator();
  integrator->set_reason_to_stop(reason_to_stop);
  watch.emplace(awake(), awake_state());
}

void Simulation::Implementation::make_own_integrator() {
  const auto after_change = [this](const std::string& text) {
    if (changing != nullptr) sleeping = changing->sleeping();
    watch.emplace(awake(), awake_state(), integrator->time());
    if (!text.empty()) decide(text);
  };
  if (changes_in_time(scene)) {
    auto made = std::make_unique<ChangingSceneIntegrator>(scene, *dynamics);
    changing = made.get();
    sleeping = changing->sleeping();
    changing->set_after_change(after_change);
    integrator = std::move(made);
  } else if (may_sleep(scene)) {
    auto made = std::make_unique<SleepingIntegrator>(scene, *dynamics);
    sleeping = made.get();
    sleeping->set_after_change(after_change);
    integrator = std::move(made);
  } else {
    integrator = make_integrator(scene, *dynamics);
  }
}

// True if a check is due whatever the frames are.
bool Simulation::Implementation::is_look_due() const {
  const TimeMethodTraits& traits = traits_of(scene.source.time.method);
  const bool may_wait = traits.is_explicit || traits.has_error_control();
  if (!may_wait || watch->external().is_possible()) return true;
  return steps_since_look >= steps_between_looks;
}

// Checks the energy at the end of the last step, if a check is due.
std::optional<Failure> Simulation::Implementation::judge_step() {
  if (!watch->applies()) return std::nullopt;
  ++steps_since_look;
  const bool is_due = is_look_due();
  if (!is_due && !frame_times.are_between(last_look, integrator->time())) return std::nullopt;
  const PhaseTimer timer(statistics.phases.energies);
  if (is_due) steps_since_look = 0;
  last_look = integrator->time();
  const Energies of_awake = energies_of_awake();
  energies = with_asleep(of_awake);
  auto failure = watch->check(last_look, awake_state(), of_awake);
  // Frames do not change the motion.
  if (is_due && watch->has_gain()) integrator->tighten();
  if (failure && sleeping != nullptr) return sleeping->in_whole(std::move(*failure));
  return failure;
}

std::optional<Failure> Simulation::Implementation::step() {
  energies.reset();
  if (auto failure = integrator->step()) return failure;
  schedule.add_step();
  note_decisions();
  if (const Contact* contact = awake().contact()) {
    contact_pairs = contact->pairs_in_reach();
    smallest_gap = contact->smallest_gap();
  } else if (const OwnContact* own = integrator->own_contact()) {
    contact_pairs = static_cast<std::size_t>(own->pairs);
    smallest_gap = own->smallest_gap;
  }
  return judge_step();
}

void Simulation::Implementation::note_decisions() {
  if (std::string now = integrator->decision(); now != decision) {
    decision = std::move(now);
    if (!decision.empty()) decide(decision);
  }
  if (dynamics->contact() == nullptr) return;
  if (std::string now = awake().contact()->compute().text(); now != compute) {
    compute = std::move(now);
    decide("contact search on " + compute);
  }
}

int Simulation::Implementation::index_of(std::string_view body) const {
  std::vector<std::string> names;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].name == body) return static_cast<int>(b);
    names.push_back(scene.bodies[b].name);
  }
  const std::string name(body);
  throw std::invalid_argument("no body or obstacle is named " + in_quotes(name) + "; " +
                              name_hint(name, names));
}

void Simulation::Implementation::expand() const {
  if (is_expanded) return;
  is_expanded = true;
  if (inner_state.empty())
    dynamics->expand_all(integrator->time(), integrator->state(), position, velocity);
  else
    dynamics->expand_all(inner_time, inner_state, position, velocity);
}

std::vector<Vec3> Simulation::Implementation::of_body(std::string_view body,
                                                      const std::vector<Vec3>& all) const {
  const SceneBody& found = scene.bodies[index_of(body)];
  const auto part = std::span(all).subspan(found.first_particle, found.particle_count());
  return {part.begin(), part.end()};
}

void Simulation::Implementation::transfer(StateArchive& archive) {
  Case moved = scene.source;
  moved.output.frame_times.clear();  // an extended run may have more
  std::string mark(save_mark), text = motion_text(moved);
  const std::string expected_mark = mark, expected_text = text;
  std::uint64_t fingerprint = fingerprint_of(scene);
  const std::uint64_t expected_fingerprint = fingerprint;
  archive(mark);
  if (mark != expected_mark) throw std::invalid_argument("not a state that this build has saved");
  archive(text);
  if (text != expected_text) throw std::invalid_argument("the saved state of another case");
  archive(fingerprint);
  if (fingerprint != expected_fingerprint)
    throw std::invalid_argument("the saved state of a case whose files have changed since");
  integrator->transfer(archive);
  watch->transfer(archive);
  schedule.transfer(archive);
  // Statistics are restored last, so that the cost of restoring does not count.
  archive(statistics, steps_since_look, last_look, inner_state, inner_time);
  if (archive.reads() && !archive.is_at_end())
    throw std::invalid_argument("a saved state with too many bytes");
}

std::string Simulation::Implementation::bytes() {
  StateArchive archive;
  transfer(archive);
  return archive.bytes();
}

// Makes all parts anew before it reads their state, so that no cache of theirs outlives it.
void Simulation::Implementation::restore(std::string_view bytes) {
  make_parts();
  is_expanded = false;
  energies.reset();
  StateArchive archive(bytes);
  transfer(archive);
  decision = integrator->decision();
  if (dynamics->contact() != nullptr) compute = awake().contact()->compute().text();
}

Simulation::Simulation(const Scene& scene)
    : implementation_(std::make_unique<Implementation>(scene, nullptr)) {}

Simulation::Simulation(std::unique_ptr<const Scene> scene) {
  const Scene& owned = *scene;
  implementation_ = std::make_unique<Implementation>(owned, std::move(scene));
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

double Simulation::time() const {
  const Implementation& self = *implementation_;
  return self.inner_state.empty() ? self.integrator->time() : self.inner_time;
}

std::span<const double> Simulation::state() const {
  const Implementation& self = *implementation_;
  return self.inner_state.empty() ? self.integrator->state() : self.inner_state;
}

std::optional<Failure> Simulation::step() {
  Implementation& self = *implementation_;
  self.inner_state.clear();
  self.is_expanded = false;
  if (self.schedule.is_due(self.integrator->time())) {
    const std::string state = renew();
    for (StepObserver* observer : self.observers) observer->at_checkpoint(state);
    // A run that stops here computes no step again when it goes on.
    if (self.reason_to_stop) {
      if (auto reason = self.reason_to_stop()) return reason;
    }
  }
  if (auto failure = self.step()) return failure;
  for (StepObserver* observer : self.observers) observer->after_step(*this);
  return std::nullopt;
}

std::optional<Failure> Simulation::advance(double seconds) {
  Implementation& self = *implementation_;
  if (!(seconds > 0) || !std::isfinite(seconds))
    throw std::invalid_argument("a simulation advances by a positive number of seconds");
  double target = time() + seconds;
  if (traits_of(self.scene.source.time.method).finds_equilibria())
    target = std::min(target, self.scene.source.time.duration);
  while (self.integrator->time() < target && !has_ended()) {
    if (auto failure = step()) return failure;
  }
  self.is_expanded = false;
  self.inner_state.clear();
  target = has_ended() ? std::min(target, self.integrator->time()) : target;
  if (target == self.integrator->time()) return std::nullopt;
  std::vector<double> inner(self.dynamics->state_size());
  if (auto failure = self.integrator->state_at(target, inner)) return failure;
  self.inner_state = std::move(inner);
  self.inner_time = target;
  return std::nullopt;
}

std::vector<Vec3> Simulation::position(std::string_view body) const {
  implementation_->expand();
  return implementation_->of_body(body, implementation_->position);
}

std::vector<Vec3> Simulation::velocity(std::string_view body) const {
  implementation_->expand();
  return implementation_->of_body(body, implementation_->velocity);
}

void Simulation::set_velocity(std::string_view body, std::span<const Vec3> velocity) {
  Implementation& self = *implementation_;
  const SceneBody& target = self.scene.bodies[self.index_of(body)];
  const std::string name = in_quotes(std::string(body));
  if (!target.dynamic) throw std::invalid_argument(name + " is wholly prescribed");
  if (static_cast<int>(velocity.size()) != target.particle_count()) {
    throw std::invalid_argument(name + " has " + std::to_string(target.particle_count()) +
                                " vertices, not " + std::to_string(velocity.size()));
  }
  if (!std::ranges::all_of(velocity, [](const Vec3& v) { return v.allFinite(); }))
    throw std::invalid_argument("a velocity of " + name + " is not finite");
  const double now = time();
  std::vector<double> y(state().begin(), state().end());
  auto* const all = reinterpret_cast<Vec3*>(y.data()) + self.scene.dynamic_particles;
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    const int particle = target.first_particle + static_cast<int>(i);
    if (self.scene.is_free(particle)) all[particle] = velocity[i];
  }
  self.inner_state.clear();
  self.is_expanded = false;
  self.energies.reset();
  self.integrator->restart(now, y);
  self.watch.emplace(self.awake(), self.awake_state(), now);
  self.decide("new velocities of " + name + " at t = " + rounded_text(now) +
              " s: the method starts anew");
}

std::string Simulation::save() const {
  const TimeMethodTraits& method = traits_of(implementation_->scene.source.time.method);
  if (method.has_hidden_history()) {
    throw std::invalid_argument(
        "a run by " + std::string(method.name) +
        " cannot be saved: SUNDIALS keeps its history; expected one of the one-step methods, "
        "\"euler\", \"implicit_midpoint\", \"verlet\", \"static\"");
  }
  return checkpoint();
}

std::string Simulation::checkpoint() const { return implementation_->bytes(); }

void Simulation::restore(std::string_view bytes) { implementation_->restore(bytes); }

std::string Simulation::renew() {
  Implementation& self = *implementation_;
  self.schedule.start(self.integrator->time());
  std::string state = self.bytes();
  self.restore(state);
  return state;
}

bool Simulation::has_ended() const { return implementation_->integrator->has_ended(); }

IntegratorCounts Simulation::counts() const { return implementation_->integrator->counts(); }
const Statistics& Simulation::statistics() const { return implementation_->statistics; }

const Energies& Simulation::energies() const {
  Implementation& self = *implementation_;
  if (!self.energies) {
    const double time = self.integrator->time();
    self.energies = self.integrator->counts().steps == 0
                        ? self.with_spins(self.awake().energies(time, self.awake_state()), time)
                        : self.with_asleep(self.energies_of_awake());
  }
  return *self.energies;
}

StateSummary Simulation::summary_of(double time, std::span<const double> y) const {
  Implementation& self = *implementation_;
  Dynamics& awake = self.awake();
  const auto gap = [&] {
    return awake.contact() != nullptr ? awake.contact()->smallest_gap() : std::nullopt;
  };
  if (self.sleeping == nullptr) {
    const OwnContact* own = self.integrator->own_contact();
    return {self.with_spins(awake.energies(time, y), time),
            own != nullptr ? own->smallest_gap : gap(), 0};
  }
  const Energies of_awake = awake.energies(time, self.sleeping->awake_part(y));
  return {self.sleeping->with_asleep(of_awake), self.sleeping->with_asleep(gap()),
          self.sleeping->sleeping_bodies()};
}

std::size_t Simulation::contact_pairs() const { return implementation_->contact_pairs; }
std::optional<double> Simulation::smallest_gap() const { return implementation_->smallest_gap; }

std::string Simulation::decision() const { return implementation_->integrator->decision(); }

std::string Simulation::compute() const {
  const Contact* contact = implementation_->awake().contact();
  return contact == nullptr ? "" : contact->compute().text();
}

void Simulation::add_observer(StepObserver& observer) {
  Implementation& self = *implementation_;
  self.observers.push_back(&observer);
  self.compute = compute();
}

void Simulation::set_reason_to_stop(std::function<std::optional<Failure>()> reason) {
  Implementation& self = *implementation_;
  self.reason_to_stop = std::move(reason);
  self.integrator->set_reason_to_stop(self.reason_to_stop);
}

const Scene& Simulation::scene() const { return implementation_->scene; }
Dynamics& Simulation::dynamics() const { return *implementation_->dynamics; }
Dynamics& Simulation::dynamics_with_pins() const {
  const Implementation& self = *implementation_;
  return self.changing != nullptr ? self.changing->dynamics() : *implementation_->dynamics;
}
const Integrator& Simulation::integrator() const { return *implementation_->integrator; }

std::optional<Failure> Simulation::state_at(double time, std::span<double> y) const {
  return implementation_->integrator->state_at(time, y);
}

}  // namespace weft::sim
