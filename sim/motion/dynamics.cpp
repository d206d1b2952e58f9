#include "sim/motion/dynamics.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim/base/parallel.h"
#include "sim/case/time_methods.h"
#include "sim/motion/particle_masses.h"
#include "sim/scene/shell_body.h"
#include "sim/scene/sliding_supports.h"

namespace weft::sim {

StateView StateView::of(std::span<const double> y) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const std::size_t count = y.size() / 6;
  const auto* vectors = reinterpret_cast<const Vec3*>(y.data());
  return {{vectors, count}, {vectors + count, count}};
}

double Energies::total() const {
  double sum = kinetic + gravitational + contact;
  for (const auto& [name, value] : elastic) sum += value;
  return sum;
}

Dynamics::Dynamics(const Scene& scene, Statistics& statistics,
                   std::vector<std::unique_ptr<Force>> forces)
    : Dynamics(scene, statistics, std::move(forces),
               scene.source.contact.enabled ? choose_search(scene) : ChosenSearch{}) {}

namespace {

// An equilibrium depends on the weights of the particles but not on their inertia, so lumped masses
// suffice to search for it.
MassOperator::Form mass_form(const Scene& scene) {
  return traits_of(scene.source.time.method).finds_equilibria() ? MassOperator::Form::lumped
                                                                : MassOperator::Form::consistent;
}

}  // namespace

Dynamics::Dynamics(const Scene& scene, Statistics& statistics,
                   std::vector<std::unique_ptr<Force>> forces, ChosenSearch search)
    : scene_(scene),
      statistics_(statistics),
      threads_(scene.threads),
      mass_(scene, mass_form(scene)),
      forces_(std::move(forces)),
      pins_move_(std::any_of(scene.prescribed.begin(), scene.prescribed.end(),
                             [&](const PrescribedMotion& held) {
                               return held.moves && !held.particles.empty() &&
                                      held.particles[0] < scene.dynamic_particles;
                             })),
      gravity_curve_(scene.source.world.gravity),
      friction_curve_(scene.source.contact.friction),
      gravity_(scene.source.world.gravity.constant_or_zero()) {
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    if (scene.pinned[i] != 0) held_.push_back(i);
  }
  if (scene.source.contact.enabled) contact_.emplace(scene, statistics, std::move(search));
  std::vector<std::vector<int>> neighbours(scene.dynamic_particles);
  for (const auto& force : forces_) force->add_couplings(neighbours);
  mass_.add_couplings(neighbours);
  const auto pattern = std::make_shared<const BlockPattern>(neighbours);
  for (const auto& force : forces_) force->attach(*pattern);
  mass_.attach(pattern);
  stiffness_ = BlockMatrix(pattern);
  for (int b = 0; b < scene.dynamic_bodies; ++b)
    image_maps_.push_back(map_to_image(scene.bodies[b]));
  add_mass_damping();
  has_damping_ = !mass_damping_.empty() || std::ranges::any_of(forces_, [](const auto& force) {
    return force->has_damping();
  });
  has_limits_ = std::ranges::any_of(forces_, [](const auto& force) { return force->has_limits(); });
  if (has_yielding_bodies(scene)) {
    creases_ = std::make_shared<CreaseHistory>(scene);
    for (const auto& force : forces_) force->use_creases(*creases_);
  }
  varies_ = gravity_curve_.varies() || mass_damping_curves_.varies() ||
            (contact_ && friction_curve_.varies()) ||
            std::ranges::any_of(forces_, [](const auto& force) { return force->varies(); });
  if (creases_) {
    // A start shape that is bent beyond the yield curvature has its creases from the beginning.
    set_time(0);
    accept_history(0, initial_state());
  }
  if (contact_ && scene.source.contact.sticking_distance) {
    anchors_ = std::make_shared<AnchorHistory>();
    contact_->use_anchors(*anchors_);
  }
}

void Dynamics::add_mass_damping() {
  for (int b = 0; b < scene_.dynamic_bodies; ++b) {
    const SceneBody& body = scene_.bodies[b];
    const Varying<double>& damping = body.material->mass_damping;
    mass_damping_curves_.append(body.particle_count(), damping);
    if (damping.is_zero()) continue;
    mass_damping_.resize(scene_.dynamic_particles, 0.0);
    std::fill_n(mass_damping_.begin() + body.first_particle, body.particle_count(),
                damping.constant_or_zero());
  }
}

std::optional<ContactFault> Dynamics::check_limits(double time, std::span<const double> y) {
  if (!has_limits_) return std::nullopt;
  const Kinematics state = kinematics(time, y);
  for (const auto& force : forces_) {
    const int particle = force->find_beyond_limit(state.position);
    if (particle >= 0) return ContactFault{ContactFault::Kind::overstretched, {particle}};
  }
  return std::nullopt;
}

void Dynamics::set_time(double time) {
  choose_history(time);
  if (!varies_) return;
  const Instant now = instant(time);
  gravity_ = gravity_curve_.at(now);
  if (contact_ && friction_curve_.varies()) contact_->set_friction(friction_curve_.at(now));
  mass_damping_curves_.visit_changed(now, [&](int first, int last, double damping) {
    std::fill(mass_damping_.begin() + first, mass_damping_.begin() + last, damping);
  });
  for (const auto& force : forces_) {
    if (force->varies()) force->set_time(now);
  }
}

double Dynamics::evaluation_work() const {
  double work = 0.3;  // work of an evaluation without any force
  for (const auto& force : forces_) work = std::max(work, force->evaluation_work());
  return work;
}

bool Dynamics::has_external_forces() const {
  return std::ranges::any_of(forces_, [](const auto& force) {
    return force->is_external() || force->has_moving_points();
  });
}

bool Dynamics::has_moving_points() const {
  return std::ranges::any_of(forces_, [](const auto& force) { return force->has_moving_points(); });
}

std::vector<double> Dynamics::initial_state() const {
  std::vector<double> y;
  y.reserve(state_size());
  const auto append = [&](const Vec3& v) { y.insert(y.end(), v.begin(), v.end()); };
  for (int i = 0; i < scene_.dynamic_particles; ++i) append(scene_.initial_position[i]);
  for (int i = 0; i < scene_.dynamic_particles; ++i)
    append(scene_.is_free(i) ? scene_.initial_velocity(i) : Vec3(Vec3::Zero()));
  place_pins(0, y);
  match_supports(0, y);
  return y;
}

Kinematics Dynamics::kinematics(double time, std::span<const double> y) {
  set_time(time);
  // If pins do not move, y already holds their positions and zero velocities.
  if (!contact_ && !pins_move_ && !load_) {
    const StateView state = StateView::of(y);
    return {state.position, state.velocity};
  }
  expand(time, y, position_, velocity_);
  if (load_) std::fill(velocity_.begin(), velocity_.end(), Vec3::Zero());
  const auto count = static_cast<std::size_t>(scene_.dynamic_particles);
  return {std::span(position_).first(count), std::span(velocity_).first(count)};
}

void Dynamics::expand(double time, std::span<const double> y, std::vector<Vec3>& position,
                      std::vector<Vec3>& velocity) const {
  assert(y.size() == state_size());
  if (position.empty()) {
    position = scene_.initial_position;
    velocity.assign(position.size(), Vec3::Zero());
  }
  assert(static_cast<int>(position.size()) == scene_.particle_count &&
         position.size() == velocity.size());
  const StateView state = StateView::of(y);
  parallel_copy(state.position, position, threads_);
  parallel_copy(state.velocity, velocity, threads_);
  std::vector<Vec3> moved, rate;
  for (const PrescribedMotion& held : scene_.prescribed) {
    if (is_moving_obstacle(held)) continue;
    if (held.moves) {
      moved.resize(held.start.size());
      rate.resize(held.start.size());
      held.motion.apply(time, held.start, moved, rate, is_before_jump(time));
    }
    for (std::size_t i = 0; i < held.particles.size(); ++i) {
      position[held.particles[i]] = held.moves ? moved[i] : held.start[i];
      velocity[held.particles[i]] = held.moves ? rate[i] : Vec3(Vec3::Zero());
    }
  }
}

void Dynamics::expand_all(double time, std::span<const double> y, std::vector<Vec3>& position,
                          std::vector<Vec3>& velocity) const {
  expand(time, y, position, velocity);
  for (const PrescribedMotion& held : scene_.prescribed) {
    if (!is_moving_obstacle(held)) continue;
    const RigidPose pose = held.motion.pose(time, is_before_jump(time));
    for (std::size_t i = 0; i < held.particles.size(); ++i) {
      const int particle = held.particles[i];
      pose.place(held.start[i], position[particle], velocity[particle]);
    }
  }
}

std::optional<ContactFault> Dynamics::rate(double time, std::span<const double> y,
                                           std::span<double> rate) {
  const std::span<const double> velocity = y.subspan(y.size() / 2);
  std::copy(velocity.begin(), velocity.end(), rate.begin());
  auto* x_rate = reinterpret_cast<Vec3*>(rate.data());
  for (const int i : held_) x_rate[i].setZero();
  auto fault = acceleration(time, y, {x_rate + scene_.dynamic_particles, velocity.size() / 3});
  if (pins_move_ && !load_ && !fault) advance_pins(time, 1, rate);
  return fault;
}

// Calls visit(motion) for each motion that moves pins of dynamic bodies.
template <class Visit>
void Dynamics::visit_moving_pins(const Visit& visit) const {
  if (!pins_move_) return;
  for (const PrescribedMotion& held : scene_.prescribed) {
    if (held.moves && !held.particles.empty() && held.particles[0] < scene_.dynamic_particles)
      visit(held);
  }
}

void Dynamics::place_pins(double time, std::span<double> y) const {
  auto* const x = reinterpret_cast<Vec3*>(y.data());
  Vec3* const v = x + scene_.dynamic_particles;
  visit_moving_pins([&](const PrescribedMotion& held) {
    std::vector<Vec3> position(held.start.size()), velocity(held.start.size());
    held.motion.apply(time, held.start, position, velocity);
    for (std::size_t i = 0; i < held.particles.size(); ++i) {
      x[held.particles[i]] = position[i];
      v[held.particles[i]] = velocity[i];
    }
  });
}

void Dynamics::match_supports(double time, std::span<double> y) const {
  if (traits_of(scene_.source.time.method).finds_equilibria()) return;
  auto* const velocity = reinterpret_cast<Vec3*>(y.data()) + scene_.dynamic_particles;
  bool has_changed = false;
  for (int b = 0; b < scene_.dynamic_bodies; ++b) {
    const SceneBody& body = scene_.bodies[b];
    if (!body.supports) continue;
    const auto jumps = [&](const MotionEvent& event) {
      return event.jumps && std::abs(event.time - time) <= scene_.source.time.minimum_step;
    };
    if (time > 0 && std::ranges::none_of(events_of(*body.supports), jumps)) continue;
    match_velocities(
        *body.supports, time,
        {velocity + body.first_particle, static_cast<std::size_t>(body.particle_count())});
    has_changed = true;
  }
  if (has_changed) place_pins(time, y);  // pins go before supports
}

void Dynamics::advance_pins(double time, double factor, std::span<double> y) const {
  auto* const x = reinterpret_cast<Vec3*>(y.data());
  Vec3* const v = x + scene_.dynamic_particles;
  visit_moving_pins([&](const PrescribedMotion& held) {
    std::vector<Vec3> velocity(held.start.size()), acceleration(held.start.size());
    held.motion.rates(time, held.start, velocity, acceleration, is_before_jump(time));
    for (std::size_t i = 0; i < held.particles.size(); ++i) {
      x[held.particles[i]] += factor * velocity[i];
      v[held.particles[i]] += factor * acceleration[i];
    }
  });
}

// Sets the accelerations (m/s^2) of moving pins. Other entries keep their values. Sets nothing if a
// load is set, because all pins then count as at rest.
void Dynamics::find_accelerations_of_pins(double time, std::span<Vec3> acceleration) const {
  if (load_) return;
  visit_moving_pins([&](const PrescribedMotion& held) {
    std::vector<Vec3> velocity(held.start.size()), rate(held.start.size());
    held.motion.rates(time, held.start, velocity, rate, is_before_jump(time));
    for (std::size_t i = 0; i < held.particles.size(); ++i)
      acceleration[held.particles[i]] = rate[i];
  });
}

// Returns bounds (m) of the distances of prescribed particles from straight paths. All other paths
// are straight.
PathStray Dynamics::path_stray(double from, double to) {
  bool is_straight = true;
  for (const PrescribedMotion& held : scene_.prescribed) {
    if (!held.moves || held.particles.empty()) continue;
    const double stray = held.motion.bounds(from, to, held.radius).stray;
    if (stray > 0 && is_straight) {
      is_straight = false;
      body_stray_.assign(scene_.bodies.size(), 0.0);
      particle_stray_.assign(scene_.dynamic_particles, 0.0);
    }
    if (!(stray > 0)) continue;
    double& largest = body_stray_[scene_.body_index_of_particle(held.particles[0])];
    largest = std::max(largest, stray);
    if (is_moving_obstacle(held)) continue;
    for (const int particle : held.particles) particle_stray_[particle] = stray;
  }
  if (is_straight) return {};
  return {body_stray_, particle_stray_};
}

std::optional<ContactFault> Dynamics::check_path(double start_time, std::span<const Vec3> start,
                                                 double end_time, std::span<const Vec3> end) {
  assert(contact_);
  const PathStray stray = path_stray(start_time, end_time);
  return contact_->check_path(placed(start_time, start, path_start_),
                              placed(end_time, end, path_end_), stray);
}

std::optional<ContactFault> Dynamics::add_stops(double start_time, std::span<const Vec3> start,
                                                double end_time, std::span<const Vec3> end,
                                                double gamma, std::span<const Vec3> velocity,
                                                std::span<const Mat3> diagonal, int* added) {
  assert(contact_);
  const PathStray stray = path_stray(start_time, end_time);
  return contact_->add_stops({placed(start_time, start, path_start_),
                              placed(end_time, end, path_end_), stray, end_time - start_time},
                             gamma, velocity, diagonal, added);
}

std::optional<ContactFault> Dynamics::check_straight_path(double start_time,
                                                          std::span<const Vec3> start,
                                                          double end_time,
                                                          std::span<const Vec3> end, bool gap) {
  assert(contact_);
  const PlacedParticles from = placed(start_time, start, path_start_);
  const PlacedParticles to = placed(end_time, end, path_end_);
  return gap ? contact_->check_path(from, to) : contact_->check_crossing(from, to);
}

// Copies the positions if obstacles move, because contact writes the positions of their particles.
PlacedParticles Dynamics::placed(double time, std::span<const Vec3> position,
                                 Placing& placing) const {
  const RigidObstacles& obstacles = contact_->obstacles();
  if (obstacles.all().empty()) return {position, time};
  if (placing.position.empty()) placing.position.assign(position.begin(), position.end());
  std::copy_n(position.begin(), scene_.dynamic_particles, placing.position.begin());
  obstacles.find_poses(time, is_before_jump(time), placing.poses);
  return {placing.position, {}, placing.poses, time};
}

// Evaluates contact at position_ and velocity_. Precondition: expand() has set both for `time`.
// Where contact looks ahead, obstacles are where they were at the start of the step
// (SurfaceContact::begin_newton()).
std::optional<ContactFault> Dynamics::evaluate_contact(double time) {
  contact_->obstacles().find_poses(time, is_before_jump(time), poses_);
  if (const double ahead = contact_->step_ahead(); ahead > 0) {
    time -= ahead;
    std::vector<RigidPose> starts;
    contact_->obstacles().find_poses(time, false, starts);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const Eigen::AngleAxisd turn(poses_[i].rotation * starts[i].rotation.transpose());
      starts[i].velocity = (poses_[i].translation - starts[i].translation) / ahead;
      starts[i].angular_velocity = turn.angle() / ahead * turn.axis();
    }
    poses_.swap(starts);
  }
  for (RigidPose& pose : poses_) {
    if (load_) pose.velocity = pose.angular_velocity = Vec3::Zero();
  }
  return contact_->evaluate({position_, velocity_, poses_, time}, velocity_, threads_);
}

std::optional<ContactFault> Dynamics::acceleration(double time, std::span<const double> y,
                                                   std::span<Vec3> acceleration) {
  ++statistics_.counters.force_evaluations;
  const Kinematics state = kinematics(time, y);
  if (auto fault = sum_forces(time, state, acceleration)) return fault;
  if (divide_by_mass(time, state, acceleration)) return std::nullopt;
  return fault_of_first_not_finite(acceleration);
}

std::optional<ContactFault> Dynamics::sum_forces(double time, const Kinematics& state,
                                                 std::span<Vec3> force) {
  add_forces(state, force);
  if (!contact_) return std::nullopt;
  if (auto fault = evaluate_contact(time)) return fault;
  contact_->add_forces(force);
  return std::nullopt;
}

ContactFault Dynamics::fault_of_first_not_finite(std::span<const Vec3> vectors) const {
  const auto bad =
      std::find_if(vectors.begin(), vectors.end(), [](const Vec3& a) { return !a.allFinite(); });
  const auto place = std::min<std::ptrdiff_t>(bad - vectors.begin(), particle_count() - 1);
  return {ContactFault::Kind::not_finite, {static_cast<int>(place), -1, -1, -1}};
}

std::optional<ContactFault> Dynamics::net_forces(double time, std::span<const double> y,
                                                 std::span<Vec3> force) {
  ++statistics_.counters.force_evaluations;
  const Kinematics state = kinematics(time, y);
  if (auto fault = sum_forces(time, state, force)) return fault;
  add_weight_and_damping(state, force);
  if (std::ranges::all_of(force, [](const Vec3& f) { return f.allFinite(); })) return std::nullopt;
  return fault_of_first_not_finite(force);
}

void Dynamics::applied_loads(double time, std::span<const double> y, bool with_gravity,
                             std::span<Vec3> force) {
  const Kinematics state = kinematics(time, y);
  std::ranges::fill(force, Vec3::Zero());
  for (int i = 0; with_gravity && i < scene_.heavy_particles; ++i)
    force[i] = scene_.mass[i] * gravity_;
  for (const auto& each : forces_) {
    if (each->is_load()) each->add_forces(state, force, threads_);
  }
}

void Dynamics::set_load_factor(double factor) {
  for (const auto& each : forces_) {
    if (each->is_load()) each->set_load_factor(factor);
  }
}

bool Dynamics::has_loads() const {
  return std::ranges::any_of(forces_, [](const auto& each) { return each->is_load(); });
}

void Dynamics::add_forces(const Kinematics& state, std::span<Vec3> force) {
  PhaseTimer timer(statistics_.phases.forces);
  parallel_set_zero(force, threads_);
  for (const bool membrane : {true, false}) {
    for (const auto& each : forces_) {
      if (each->is_membrane() == membrane) each->add_forces(state, force, threads_);
    }
    if (!membrane || hardness_ == 1) continue;
    for (Vec3& f : force) f *= hardness_;
  }
}

void Dynamics::add_weight_and_damping(const Kinematics& state, std::span<Vec3> force) const {
  const Vec3 gravity = load_.value_or(1) * gravity_;
  for (int i = 0; i < scene_.heavy_particles; ++i) {
    const double damping = mass_damping_.empty() ? 0.0 : mass_damping_[i];
    if (mass_.is_diagonal()) {
      force[i] += scene_.mass[i] * (gravity - damping * state.velocity[i]);
      continue;
    }
    force[i] += scene_.mass[i] * gravity;
    if (damping == 0) continue;
    force[i] -= damping * mass_.row_product(i, state.velocity.data());
  }
}

// Solves M_ff a_f = F_f - M_fp a_p for the accelerations a_f, with f for free and p for held
// particles.
void Dynamics::solve_for_accelerations(double time, std::span<Vec3> force) {
  if (pins_move_ && !load_) {
    coupled_.assign(force.size(), Vec3::Zero());
    find_accelerations_of_pins(time, coupled_);
    for (std::size_t i = 0; i < force.size(); ++i)
      force[i] -= mass_.row_product(static_cast<int>(i), coupled_.data());
  }
  mass_.solve(force);
}

bool Dynamics::divide_by_mass(double time, const Kinematics& state, std::span<Vec3> force) {
  if (!mass_.is_diagonal()) {
    add_weight_and_damping(state, force);
    solve_for_accelerations(time, force);
    return std::ranges::all_of(force, [](const Vec3& each) { return each.allFinite(); });
  }
  const Vec3 gravity = load_.value_or(1) * gravity_;
  const auto heavy = static_cast<std::size_t>(scene_.heavy_particles);
  const std::span<const double> mass(scene_.mass);
  double sum = accelerate(mass.first(heavy), gravity, force.first(heavy));
  sum += accelerate(mass.subspan(heavy), Vec3::Zero(), force.subspan(heavy));
  for (std::size_t i = 0; i < mass_damping_.size(); ++i) {
    const Vec3 slowing = mass_damping_[i] * state.velocity[i];
    force[i] -= slowing;
    sum -= slowing.sum();
  }
  for (const int i : held_) force[i].setZero();
  return std::isfinite(sum);
}

void Dynamics::assemble(double time, std::span<const double> y, Definiteness definiteness) {
  note_place(time, y, definiteness, 0);
  damping_product_ = {};
  if (has_damping_ && damping_.is_empty()) damping_ = BlockMatrix(stiffness_.shared_pattern());
  damping_.set_zero(threads_);
  assemble(time, y, definiteness, {.stiffness = stiffness_, .damping = &damping_});
  if (load_) damping_.set_zero(threads_);
}

void Dynamics::assemble_joined(double time, std::span<const double> y, Definiteness definiteness,
                               double gamma, std::span<const Vec3> residual) {
  assert(!load_ && hardness_ == 1);
  note_place(time, y, definiteness, gamma);
  damping_ = {};
  if (has_damping_) damping_product_.assign(residual.size(), Vec3::Zero());
  assemble(time, y, definiteness,
           {.stiffness = stiffness_,
            .inverse_gamma = 1 / gamma,
            .along = residual,
            .product = damping_product_});
}

void Dynamics::assemble(double time, std::span<const double> y, Definiteness definiteness,
                        const Derivatives& into) {
  ++statistics_.counters.matrix_assemblies;
  PhaseTimer timer(statistics_.phases.linear_solve);
  const Kinematics state = kinematics(time, y);
  stiffness_.set_zero(threads_);
  for (const bool membrane : {true, false}) {
    for (const auto& force : forces_) {
      if (force->is_membrane() != membrane) continue;
      if (supports_are_left_out_ && force->is_support()) continue;
      force->add_derivatives(state, into, definiteness, threads_);
    }
    if (membrane && hardness_ != 1) stiffness_.scale(hardness_);
  }
  add_mass_damping(into);
}

void Dynamics::add_mass_damping(const Derivatives& into) {
  BlockMatrix& matrix = into.is_joined() ? stiffness_ : damping_;
  const BlockPattern& pattern = matrix.pattern();
  const double factor = into.is_joined() ? into.inverse_gamma : 1;
  for (std::size_t particle = 0; particle < mass_damping_.size(); ++particle) {
    const double rate = mass_damping_[particle];
    if (rate == 0) continue;
    const int i = static_cast<int>(particle), diagonal = pattern.diagonal_slot(i);
    const int end = mass_.is_diagonal() ? diagonal + 1 : pattern.row_end(i);
    for (int slot = diagonal; slot < end; ++slot) {
      matrix.upper_block(pattern.upper(i, slot)).diagonal().array() +=
          factor * (rate * mass_.at(i, slot));
    }
    if (!into.is_joined()) continue;
    damping_product_[i] += mass_.is_diagonal()
                               ? Vec3(rate * scene_.mass[i] * into.along[i])
                               : Vec3(rate * mass_.row_product(i, into.along.data()));
  }
}

void Dynamics::note_place(double time, std::span<const double> y, Definiteness definiteness,
                          double gamma) {
  choose_history(time);
  linearisation_.time = time;
  linearisation_.step_start = step_start_;
  linearisation_.state.assign(y.begin(), y.end());
  linearisation_.definiteness = definiteness;
  linearisation_.gamma = gamma;
  linearisation_.load = load_;
  linearisation_.hardness = hardness_;
  if (creases_) linearisation_.creases = creases_->selected();
  if (anchors_) linearisation_.anchors = anchors_->selected();
}

void Dynamics::assemble_again(const Linearisation& place) {
  const Linearisation kept = place;
  load_ = kept.load;
  hardness_ = kept.hardness;
  step_start_ = kept.step_start;
  if (creases_) creases_->fix(&kept.creases);
  if (anchors_) anchors_->fix(&kept.anchors);
  std::vector<double> unused(kept.state.size());
  static_cast<void>(rate(kept.time, kept.state, unused));  // evaluates contact's matrices
  if (kept.gamma == 0) {
    assemble(kept.time, kept.state, kept.definiteness);
  } else {
    const std::vector<Vec3> residual(particle_count(), Vec3::Zero());
    assemble_joined(kept.time, kept.state, kept.definiteness, kept.gamma, residual);
  }
  if (creases_) creases_->fix(nullptr);
  if (anchors_) anchors_->fix(nullptr);
}

}  // namespace weft::sim
