// Rigid spheres that collide by impulses: TimeMethod::impulses.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "sim/case/case_text.h"
#include "sim/case/frame_times.h"
#include "sim/integrator/integrator_makers.h"
#include "sim/particles/displacement_solver.h"
#include "sim/particles/impulse_solver.h"
#include "sim/particles/sphere_search.h"
#include "sim/scene/scene_curves.h"
#include "sim/scene/sphere_groups.h"

namespace weft::sim {

namespace {

// Steps without time.step last this fraction of the time in which a sphere falls by half its
// radius.
constexpr double default_step_share = 1.0 / 10;
// Largest displacement of a sphere in a step, as a fraction of the smallest radius. With one radius
// and more, a sphere could pass an edge of an obstacle between two steps.
constexpr double largest_move = 0.75;
// Largest displacement of most spheres in a step, likewise. Spheres that pour onto each other then
// meet one neighbour per step, not several. `fast_share` of the spheres may be faster.
constexpr double usual_move = 0.17, fast_share = 0.2;
// Times that overlaps are corrected together before spheres stay in place, and until they stay in
// place without further corrections.
constexpr int free_rounds = 4, corrected_rounds = 12;

// Half of the drag coefficient times the area of the cross-section, per mass (m^2/kg).
std::vector<double> drag_factors(const Scene& scene) {
  std::vector<double> factors;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const double radius = body.spheres->radius;
    const double area = std::numbers::pi * radius * radius;
    factors.insert(factors.end(), body.particle_count(),
                   0.5 * body.spheres->drag_coefficient * area / scene.mass[body.first_particle]);
  }
  return factors;
}

std::vector<Vec3> start_spins(const Scene& scene) {
  std::vector<Vec3> spins;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const ParticlesCase& from = *scene.bodies[b].spheres;
    const Vec3 spin = from.angular_velocity_deg * (std::numbers::pi / 180);
    spins.insert(spins.end(), scene.bodies[b].particle_count(),
                 from.spin ? spin : Vec3(Vec3::Zero()));
  }
  return spins;
}

// Returns the times (s) at which motions of obstacles and varying values are not smooth.
std::vector<double> event_times(const Scene& scene) {
  std::vector<double> times;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (!held.moves) continue;
    for (auto event = held.motion.next_event(0); event; event = held.motion.next_event(event->time))
      times.push_back(event->time);
  }
  for (const MotionEvent& event : SceneCurves(scene.source).events()) times.push_back(event.time);
  std::ranges::sort(times);
  return times;
}

class ImpulseIntegrator final : public Integrator {
 public:
  ImpulseIntegrator(const Scene& scene, Dynamics& dynamics)
      : scene_(scene),
        dynamics_(dynamics),
        count_(scene.dynamic_particles),
        surfaces_(scene),
        laws_(scene),
        search_(scene, surfaces_, laws_, dynamics.statistics()),
        solver_(scene),
        displacements_(solver_.rest_gaps(), solver_.inverse_masses()),
        padding_(4 * *std::ranges::max_element(solver_.rest_gaps())),
        friction_(scene.source.contact.friction),
        wind_(scene.source.world.wind),
        air_density_(scene.source.world.air_density),
        drag_(drag_factors(scene)),
        has_drag_(std::ranges::any_of(drag_, [](double factor) { return factor > 0; })),
        smallest_radius_(*std::ranges::min_element(search_.radii())),
        largest_radius_(*std::ranges::max_element(search_.radii())),
        events_(event_times(scene)),
        longest_step_(SceneCurves(scene.source).longest_step()),
        obstacles_move_(std::ranges::any_of(
            surfaces_.all(), [](const auto& surface) { return surface.motion != nullptr; })),
        frame_times_(scene.source),
        state_(dynamics.initial_state()),
        before_(state_),
        spin_(start_spins(scene)),
        spin_before_(spin_) {}

  std::optional<Failure> step() override;
  double time() const override { return time_; }
  double last_step() const override { return time_ - start_time_; }
  int last_order() const override { return 2; }
  std::span<const double> state() const override { return state_; }
  std::optional<Failure> state_at(double time, std::span<double> y) const override;
  IntegratorCounts counts() const override { return counts_; }
  void restart(double time, std::span<const double> y) override;
  void transfer(StateArchive& archive) override {
    archive(time_, start_time_, state_, before_, spin_, spin_before_, kicks_, counts_, own_.pairs,
            own_.smallest_gap);
    solver_.transfer(archive);
    displacements_.transfer(archive);
  }
  const OwnContact* own_contact() const override { return &own_; }
  std::vector<Vec3> spins_at(double time) const override;
  double spin_energy_at(double time) const override;

 private:
  std::span<const Vec3> positions() const { return StateView::of(state_).position; }
  std::span<const Vec3> velocities() const { return StateView::of(state_).velocity; }
  double default_step() const;
  void find_accelerations(double length);
  std::optional<double> choose_length();
  double time_to_next_event();
  std::optional<Failure> try_step(double length);
  std::optional<Failure> collide(const SphereStart& start, const ImpulseStep& step);
  void find_reach(const ImpulseStep& step);
  std::optional<Failure> separate(const SphereStart& start);
  bool fix_overlapping();
  void move(double length);
  void move_again(double length);
  double obstacle_travel(double end, double farthest) const;
  std::optional<Failure> thrown_sphere() const;
  Failure failure(const SphereContact& contact) const;
  void note_contacts(std::span<const SphereContact> contacts);
  template <class Use>
  void for_each_kick(double time, const Use& use) const;
  // Returns the part of the last step that precedes `time`.
  double share_of_step(double time) const { return (time - start_time_) / (time_ - start_time_); }

  const Scene& scene_;
  Dynamics& dynamics_;
  int count_;
  SphereSurfaces surfaces_;
  SphereLaws laws_;
  SphereSearch search_;
  ImpulseSolver solver_;
  DisplacementSolver displacements_;
  double padding_;  // m, gap of contacts of spheres that do not approach each other
  TimeCurve<double> friction_;
  TimeCurve<Vec3> wind_;
  TimeCurve<double> air_density_;
  std::vector<double> drag_;
  bool has_drag_;
  double smallest_radius_, largest_radius_;
  std::vector<double> events_;  // s, sorted: when motions and curves are not smooth
  double longest_step_;         // s, resolves every gust
  bool obstacles_move_;
  FrameTimes frame_times_;
  long next_frame_ = 0;                   // the first frame that is not known to have passed
  double time_ = 0, start_time_ = 0;      // s, end and start of the last step
  std::vector<double> state_, before_;    // at time_ and at start_time_
  std::vector<Vec3> spin_, spin_before_;  // rad/s, by sphere
  std::vector<Kick> kicks_;               // of the last step
  IntegratorCounts counts_;
  OwnContact own_;
  // Scratch of a step, by sphere.
  std::vector<Vec3> acceleration_, velocity_, turned_, mean_, end_;
  std::vector<double> reach_;          // m
  std::vector<double> squared_speed_;  // m^2/s^2
  std::vector<char> changed_;
  std::vector<SphereContact> contacts_, overlaps_;
  std::vector<Kick> new_kicks_;
};

double ImpulseIntegrator::default_step() const {
  const double gravity = dynamics_.gravity(time_).norm();
  const double frame = 1 / scene_.source.time.frames_per_second;
  if (!(gravity > 0)) return frame;
  return std::min(frame, default_step_share * std::sqrt(smallest_radius_ / gravity));
}

// Returns the time (s) until a step must end: at the next event and, beside obstacles that move, at
// the next frame. Between the ends of a step, spheres are interpolated along straight paths, which
// obstacles on curved paths may touch.
double ImpulseIntegrator::time_to_next_event() {
  const double passed = time_ + scene_.source.time.minimum_step;
  const auto event = std::ranges::upper_bound(events_, passed);
  const double next = event == events_.end() ? std::numeric_limits<double>::infinity() : *event;
  if (!obstacles_move_) return next - time_;
  auto frame = frame_times_.at(next_frame_);
  while (frame && *frame <= passed) frame = frame_times_.at(++next_frame_);
  return std::min(next, frame.value_or(next)) - time_;
}

// Finds the mean accelerations of free spheres during the step, with gravity and wind as they are
// in the middle of it. Gravity acts for half a step, drag for a whole one, gravity for the other
// half. Drag alone slows a sphere's velocity u relative to the air to u / (1 + k |u| t), so that no
// step, however long, reverses it. The error is of second order.
void ImpulseIntegrator::find_accelerations(double length) {
  const double middle_time = time_ + 0.5 * length;
  const Vec3 gravity = dynamics_.gravity(middle_time);
  acceleration_.assign(count_, gravity);
  if (!has_drag_) return;
  const Instant now = dynamics_.instant(middle_time);
  const Vec3 wind = wind_.at(now);
  const double density = air_density_.at(now);
  for (int i = 0; i < count_; ++i) {
    const Vec3 flow = velocities()[i] + 0.5 * length * gravity - wind;
    const double rate = drag_[i] * density * flow.norm();  // 1/s
    acceleration_[i] -= rate / (1 + rate * length) * flow;
  }
}

// Returns the length of the next step: the wanted one, divided by a whole number such that no
// sphere moves too far, by itself and towards obstacles, and no more than a few of many. Returns
// nothing if that is too short.
std::optional<double> ImpulseIntegrator::choose_length() {
  const double wanted = std::min(
      {scene_.source.time.step.value_or(default_step()), longest_step_, time_to_next_event()});
  find_accelerations(wanted);
  squared_speed_.resize(count_);
  for (int i = 0; i < count_; ++i) {
    const Vec3& velocity = velocities()[i];
    squared_speed_[i] =
        std::max(velocity.squaredNorm(), (velocity + wanted * acceleration_[i]).squaredNorm());
  }
  const auto usual = squared_speed_.end() - 1 - static_cast<int>(fast_share * count_);
  std::ranges::nth_element(squared_speed_, usual);
  const double fastest = *std::max_element(usual, squared_speed_.end());
  const double farthest = wanted * std::sqrt(fastest);
  const double travel =
      std::max((farthest + obstacle_travel(time_ + wanted, farthest)) / largest_move,
               wanted * std::sqrt(*usual) / usual_move);
  const double parts = std::max(1.0, std::ceil(travel / smallest_radius_));
  const double length = wanted / parts;
  const double longest = wanted * smallest_radius_ / travel;
  if (parts > 1 && !(longest > scene_.source.time.minimum_step)) return std::nullopt;
  if (parts > 1) find_accelerations(length);
  return length;
}

std::optional<Failure> ImpulseIntegrator::step() {
  if (auto failure = reason_to_stop()) return failure;
  dynamics_.begin_step(time_);
  std::optional<double> length = choose_length();
  if (!length) {
    return Failure{Failure::Kind::unstable, time_, -1,
                   "at t = " + rounded_text(time_) +
                       " s particles or obstacles are so fast that a step must be shorter than the "
                       "minimum_step"};
  }
  for (;;) {
    auto failure = try_step(*length);
    bool is_thrown = false;
    if (!failure) {
      failure = thrown_sphere();
      if (!failure) break;
      is_thrown = true;
      displacements_.forget();
    }
    // Obstacles that move may leave room on a shorter way, and spheres are thrown less far.
    const bool can_help = obstacles_move_ || is_thrown;
    if (!can_help || 0.5 * *length < scene_.source.time.minimum_step) return failure;
    *length *= 0.5;
    find_accelerations(*length);
    ++counts_.vetoed_steps;
  }
  if (!std::ranges::all_of(end_, [](const Vec3& x) { return x.allFinite(); })) {
    return Failure{Failure::Kind::not_finite, time_, -1,
                   "at t = " + rounded_text(time_) + " s a position is not finite"};
  }
  before_.swap(state_);
  auto* const x = reinterpret_cast<Vec3*>(state_.data());
  std::ranges::copy(end_, x);
  std::ranges::copy(velocity_, x + count_);
  spin_before_.swap(spin_);
  spin_.swap(turned_);
  kicks_.swap(new_kicks_);
  start_time_ = time_;
  time_ += *length;
  ++counts_.steps;
  return std::nullopt;
}

// Finds the state at the end of a step of this length. Fails if surfaces cannot be kept apart.
std::optional<Failure> ImpulseIntegrator::try_step(double length) {
  ++dynamics_.statistics().counters.force_evaluations;
  laws_.set_friction(friction_.at(dynamics_.instant(time_ + 0.5 * length)));
  const std::vector<RigidPose> poses = surfaces_.poses(time_),
                               ends = surfaces_.poses(time_ + length, true);
  const SphereStart start{positions(), velocities(), acceleration_, poses, ends, length};
  const double gravity = dynamics_.gravity(time_ + 0.5 * length).norm();
  const ImpulseStep step{length, 0.5 * length * gravity, velocities(), acceleration_};
  velocity_.resize(count_);
  turned_ = spin_;
  mean_.resize(count_);
  end_.resize(count_);
  return collide(start, step);
}

// Moves spheres by their displacements.
void ImpulseIntegrator::move(double length) {
  for (int i = 0; i < count_; ++i) end_[i] = positions()[i] + length * displacements_.mean(i);
}

// Moves spheres anew. Notes those that were elsewhere before and those that overlapped something.
void ImpulseIntegrator::move_again(double length) {
  changed_.assign(count_, 0);
  for (int i = 0; i < count_; ++i) {
    const Vec3 end = positions()[i] + length * displacements_.mean(i);
    if (end != end_[i]) changed_[i] = 1;
    end_[i] = end;
  }
  for (const SphereContact& overlap : overlaps_) {
    changed_[overlap.sphere] = 1;
    if (overlap.other >= 0) changed_[overlap.other] = 1;
  }
}

// Returns the largest distance (m) that a point of an obstacle moves until `end` (s). Obstacles do
// not count that stay away from all spheres, which move by up to `farthest` (m).
double ImpulseIntegrator::obstacle_travel(double end, double farthest) const {
  if (!obstacles_move_) return 0;
  Eigen::AlignedBox3d box;
  for (const Vec3& place : positions()) box.extend(place);
  double largest = 0;
  for (const ObstacleSurface& surface : surfaces_.all()) {
    if (surface.motion == nullptr) continue;
    const double travel = surface.motion->bounds(time_, end, surface.radius).travel;
    const RigidPose pose = surface.motion->pose(time_);
    const double reach =
        surface.radius + travel + surface.half_thickness + largest_radius_ + padding_ + farthest;
    if (box.exteriorDistance(Vec3(pose.centre + pose.translation)) <= reach)
      largest = std::max(largest, travel);
  }
  return largest;
}

// Finds the velocities, spins and positions at the end of the step.
std::optional<Failure> ImpulseIntegrator::collide(const SphereStart& start,
                                                  const ImpulseStep& step) {
  if (!scene_.spheres_collide) {
    new_kicks_.clear();
    for (int i = 0; i < count_; ++i) {
      velocity_[i] = step.velocity[i] + step.length * step.acceleration[i];
      mean_[i] = 0.5 * (step.velocity[i] + velocity_[i]);
    }
    displacements_.start({}, step.length, mean_);
    move(step.length);
    return std::nullopt;
  }
  find_reach(step);
  search_.find_contacts(start, reach_, padding_, contacts_);
  {
    const PhaseTimer timer(dynamics_.statistics().phases.linear_solve);
    solver_.find_velocities(contacts_, step, velocity_, turned_);
    solver_.find_kicks(contacts_, new_kicks_);
    solver_.find_displacements(step, velocity_, mean_);
    displacements_.start(contacts_, step.length, mean_);
    displacements_.correct();
    counts_.linear_iterations = solver_.sweeps();
  }
  note_contacts(contacts_);
  return separate(start);
}

// Finds how far each sphere moves freely, plus the motion of obstacles and the gap at rest.
void ImpulseIntegrator::find_reach(const ImpulseStep& step) {
  double farthest = 0;
  reach_.resize(count_);
  for (int i = 0; i < count_; ++i) {
    const double speed = step.velocity[i].norm(),
                 growth = step.length * step.acceleration[i].norm();
    const double way = step.length * (speed + 0.5 * growth);
    reach_[i] = way + 2 * solver_.rest_gaps()[i];
    farthest = std::max(farthest, way);
  }
  const double travel = obstacle_travel(time_ + step.length, farthest);
  for (double& reach : reach_) reach += travel;
}

// Moves the spheres, and corrects their displacements until none overlaps anything. Contacts that
// the search left out are added. Spheres that still overlap stay where they are: the start of the
// step is free of overlaps.
std::optional<Failure> ImpulseIntegrator::separate(const SphereStart& start) {
  changed_.clear();
  move(start.length);
  for (int round = 0;; ++round) {
    search_.find_overlaps(start, end_, changed_, overlaps_);
    if (overlaps_.empty()) {
      displacements_.keep_energy(dynamics_.gravity(time_ + 0.5 * start.length), velocity_);
      displacements_.keep();
      return std::nullopt;
    }
    const PhaseTimer timer(dynamics_.statistics().phases.linear_solve);
    if (round >= free_rounds && !fix_overlapping()) return failure(overlaps_.front());
    if (round < corrected_rounds) {
      displacements_.add(overlaps_);
      displacements_.correct();
    }
    move_again(start.length);
  }
}

// Lets the spheres that overlap something stay where they are. Returns false if they do already.
bool ImpulseIntegrator::fix_overlapping() {
  bool is_new = false;
  for (const SphereContact& overlap : overlaps_) {
    for (const int sphere : {overlap.sphere, overlap.other})
      is_new |= sphere >= 0 && displacements_.fix(sphere);
  }
  return is_new;
}

// Fails if impacts and corrections move a sphere farther than largest_move. It could then be on the
// other side of a thin obstacle, without an overlap at the end of the step.
std::optional<Failure> ImpulseIntegrator::thrown_sphere() const {
  double farthest = 0;
  int thrown = 0;
  for (int i = 0; i < count_; ++i) {
    const double way = (end_[i] - positions()[i]).squaredNorm();
    if (!(way > farthest)) continue;
    farthest = way;
    thrown = i;
  }
  if (std::sqrt(farthest) <= largest_move * smallest_radius_ * (1 + 1e-9)) return std::nullopt;
  return Failure{Failure::Kind::surfaces, time_, thrown,
                 "no step from t = " + rounded_text(time_) + " s keeps " +
                     scene_.describe_particle(thrown) +
                     " from being thrown by more than 3/4 of the smallest radius: there is no "
                     "room"};
}

Failure ImpulseIntegrator::failure(const SphereContact& contact) const {
  const std::string partner =
      contact.other >= 0
          ? scene_.describe_particle(contact.other)
          : "obstacle \"" + scene_.bodies[surfaces_.all()[contact.surface].body].name + "\"";
  return {Failure::Kind::surfaces, time_, contact.sphere,
          "no step from t = " + rounded_text(time_) + " s keeps " +
              scene_.describe_particle(contact.sphere) + " apart from " + partner +
              ", which moves: there is no room"};
}

void ImpulseIntegrator::note_contacts(std::span<const SphereContact> contacts) {
  own_.pairs = static_cast<std::int64_t>(contacts.size());
  own_.smallest_gap.reset();
  for (const SphereContact& contact : contacts)
    own_.smallest_gap = std::min(own_.smallest_gap.value_or(contact.gap), contact.gap);
}

double ImpulseIntegrator::spin_energy_at(double time) const {
  const std::vector<Vec3> spins = spins_at(time);
  double sum = 0;
  for (int i = 0; i < count_; ++i) sum += 0.5 * solver_.inertia(i) * spins[i].squaredNorm();
  return sum;
}

// Calls use(kick, part) for the kicks of the last step. A straight line between the values at both
// ends of the step, plus `part` times every kick, jumps where impacts do.
template <class Use>
void ImpulseIntegrator::for_each_kick(double time, const Use& use) const {
  const double share = share_of_step(time);
  for (const Kick& kick : kicks_) use(kick, (start_time_ + kick.time <= time ? 1 : 0) - share);
}

// Between the ends of a step, spheres are interpolated along straight paths, on which the
// constraints of contacts hold too. Their velocities are those before and after impacts.
std::optional<Failure> ImpulseIntegrator::state_at(double time, std::span<double> y) const {
  if (time >= time_) {
    std::ranges::copy(state_, y.begin());
    return std::nullopt;
  }
  const double share = share_of_step(time);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = before_[i] + share * (state_[i] - before_[i]);
  auto* const velocity = reinterpret_cast<Vec3*>(y.data()) + count_;
  for_each_kick(time, [&](const Kick& kick, double part) {
    velocity[kick.sphere] += part * Vec3(kick.velocity.data());
  });
  return std::nullopt;
}

std::vector<Vec3> ImpulseIntegrator::spins_at(double time) const {
  if (time >= time_) return spin_;
  const double share = share_of_step(time);
  std::vector<Vec3> spins = spin_before_;
  for (int i = 0; i < count_; ++i) spins[i] += share * (spin_[i] - spin_before_[i]);
  for_each_kick(time, [&](const Kick& kick, double part) {
    spins[kick.sphere] += part * Vec3(kick.spin.data());
  });
  return spins;
}

void ImpulseIntegrator::restart(double time, std::span<const double> y) {
  spin_ = spin_before_ = spins_at(time);
  time_ = start_time_ = time;
  state_.assign(y.begin(), y.end());
  before_ = state_;
  kicks_.clear();
  solver_.forget();
  displacements_.forget();
  ++counts_.restarts;
}

}  // namespace

std::unique_ptr<Integrator> make_impulse_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<ImpulseIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
