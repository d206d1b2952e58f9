#include "sim/contact/snapshot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "materials/lanes.h"
#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

using materials::Lanes;

// Bodies look ahead while their steps are no longer than this part of the paths ahead. Paths of
// longer steps would be left before they have served.
constexpr double longest_step = 0.5;

// One number in float32 for each lane.
using Floats = float __attribute__((vector_size(materials::lane_count * sizeof(float))));

// Return upper bounds in float32.
float rounded_up(double distance) {
  return static_cast<float>(distance) * (1 + 2 * std::numeric_limits<float>::epsilon());
}
Floats rounded_up(const Lanes& distance) {
  return __builtin_convertvector(distance.values, Floats) *
         (1 + 2 * std::numeric_limits<float>::epsilon());
}

Floats loaded(const float* at) {
  Floats result;
  std::memcpy(&result, at, sizeof(Floats));
  return result;
}

template <class Real>
using Vector = std::array<Real, 3>;

// Returns `points` from `i` on, minus the origin: one, or one per lane.
template <class Real>
Vector<Real> points_at(std::span<const Vec3> points, int i, const Vec3& origin) {
  if constexpr (std::is_same_v<Real, Lanes>) {
    const auto [x, y, z] = materials::load_vectors(points[i].data());
    return {x - origin.x(), y - origin.y(), z - origin.z()};
  } else {
    return {points[i].x() - origin.x(), points[i].y() - origin.y(), points[i].z() - origin.z()};
  }
}

template <class Real>
Real squared_distance(const Vector<Real>& a, const Vector<Real>& b) {
  const Real x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

// The recorded paths of a body's points, m.
struct RecordedPaths {
  std::span<const Vec3> start, end;
  // The parts of the paths at which the ends of the present paths are expected.
  double start_part = 0, end_part = 1;

  // Returns the expected positions of the points from `i` on.
  template <class Real>
  Vector<Real> at(int i, double part) const {
    const Vector<Real> last = points_at<Real>(end, i, Vec3::Zero());
    if (start.data() == end.data()) return last;
    const Vector<Real> first = points_at<Real>(start, i, Vec3::Zero());
    const Real rest = 1 - part, gone = part;
    return {rest * first[0] + gone * last[0], rest * first[1] + gone * last[1],
            rest * first[2] + gone * last[2]};
  }
  // Returns the squared displacements of the points from `i` on.
  template <class Real>
  Real squared_displacement(int i, const BodyPaths& now) const {
    const auto from_expected = [&](std::span<const Vec3> points, const Vec3& origin, double part) {
      return squared_distance(points_at<Real>(points, i, origin), at<Real>(i, part));
    };
    const Real at_end = from_expected(now.end, now.end_origin, end_part);
    if (!now.is_path()) return at_end;
    return materials::larger(at_end, from_expected(now.start, now.start_origin, start_part));
  }
};

// The largest displacement of some points, and the largest growth of a displacement since the last
// choice, m.
struct Largest {
  float displacement = 0, growth = 0;
  void add(float moved, float chosen) {
    displacement = std::max(displacement, moved);
    growth = std::max(growth, moved - chosen);
  }
  void add(const Largest& other) {
    displacement = std::max(displacement, other.displacement);
    growth = std::max(growth, other.growth);
  }
};

// Returns a speed of the points of a body, m/s: the root mean square, but no less than half of the
// largest speed.
double typical_speed(const BodyPaths& now) {
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < now.end.size(); ++i) {
    const double squared = now.rate(i).squaredNorm();
    sum += squared;
    largest = std::max(largest, squared);
  }
  return std::sqrt(std::max(sum / static_cast<double>(now.end.size()), largest / 4));
}

}  // namespace

Vec3 BodyPaths::rate(std::size_t i) const {
  if (is_path() && end_time > start_time)
    return (end_of(i) - start_of(i)) / (end_time - start_time);
  return is_path() || velocity.empty() ? Vec3(Vec3::Zero()) : velocity[i] - velocity_origin;
}

Snapshot::Snapshot(const Scene& scene, int point_count)
    : scene_(scene),
      bodies_(scene.bodies.size()),
      end_(point_count, Vec3::Zero()),
      displacement_(point_count, 0.0F),
      chosen_(point_count, 0.0F),
      renewed_(point_count, 0) {}

std::span<const Vec3> Snapshot::of_body(std::span<const Vec3> all, int body) const {
  return all.subspan(scene_.bodies[body].first_point, scene_.bodies[body].point_count());
}

void Snapshot::measure(int body, const BodyPaths& now) {
  Body& state = bodies_[body];
  if (!state.recorded) {
    state.displacement = std::numeric_limits<double>::infinity();
    return;
  }
  // Without times, the ends of a path belong to those of the recorded one.
  const double start_part = state.looks_ahead() ? state.part_at(now.start_time) : 0;
  const RecordedPaths recorded{start(body), end(body), start_part, state.part_at(now.end_time)};
  float* const displacement = displacement_.data() + scene_.bodies[body].first_point;
  const float* const chosen = chosen_.data() + scene_.bodies[body].first_point;
  const auto measure_part = [&](int first, int last, Largest& part) {
    part = {};
    Floats largest{}, most_grown{};
    int i = first;
    for (; i + materials::lane_count <= last; i += materials::lane_count) {
      const Floats moved =
          rounded_up(materials::square_root(recorded.squared_displacement<Lanes>(i, now)));
      std::memcpy(&displacement[i], &moved, sizeof(Floats));
      largest = moved > largest ? moved : largest;
      const Floats grown = moved - loaded(&chosen[i]);
      most_grown = grown > most_grown ? grown : most_grown;
    }
    for (; i < last; ++i) {
      displacement[i] = rounded_up(std::sqrt(recorded.squared_displacement<double>(i, now)));
      part.add(displacement[i], chosen[i]);
    }
    for (int k = 0; k < materials::lane_count; ++k) part.add({largest[k], most_grown[k]});
  };
  Largest largest;
  const int count = static_cast<int>(now.end.size());
  for (const Largest& part : parallel_parts<Largest>(count, scene_.threads, measure_part))
    largest.add(part);
  state.displacement = largest.displacement;
  // The factor covers the rounding of differences.
  if (state.growth < std::numeric_limits<double>::infinity())
    state.growth = largest.growth * (1 + 1e-6);
}

void Snapshot::choose(int body) {
  const SceneBody& of = scene_.bodies[body];
  std::copy_n(displacement_.begin() + of.first_point, of.point_count(),
              chosen_.begin() + of.first_point);
  bodies_[body].growth = 0;
}

void Snapshot::renew(int body, const BodyPaths& now, const RecordRules& rules) {
  const double speed = rules.ahead > 0 ? typical_speed(now) : 0;
  const bool is_short = speed * (now.end_time - now.start_time) <= longest_step * rules.ahead;
  if (speed > 0 && std::isfinite(speed) && is_short) return look_ahead(body, now, rules, speed);
  Body& state = bodies_[body];
  double longest = 0;
  if (now.is_path()) {
    for (std::size_t i = 0; i < now.end.size(); ++i)
      longest = std::max(longest, (now.end_of(i) - now.start_of(i)).squaredNorm());
  }
  const bool with_paths = longest > rules.short_path * rules.short_path;
  if (!state.recorded || state.looks_ahead() || state.has_paths != with_paths)
    return record_all(body, now, with_paths);
  const int first = scene_.bodies[body].first_point;
  for (std::size_t i = 0; i < now.end.size(); ++i) {
    const std::size_t point = first + i;
    const bool is_asked_for = !rules.others.empty() && rules.others[point] != 0;
    if (!(displacement_[point] > rules.limit) && !is_asked_for) continue;
    place(static_cast<int>(point), with_paths ? now.start_of(i) : now.end_of(i), now.end_of(i));
    renewed_[point] = 1;
  }
  state.renewed = true;
  measure(body, now);
}

double Snapshot::Body::part_at(double time) const {
  return looks_ahead() ? std::clamp((time - from) / (until - from), 0.0, 1.0) : 1;
}

// Returns true if the recorded paths serve for the present ones, and are no longer than usual at
// the present speed (m/s), neither before nor after these.
bool Snapshot::Body::suit(const BodyPaths& now, double speed, double ahead) const {
  const double first = now.is_path() ? now.start_time : now.end_time;
  if (!recorded || !looks_ahead() || first < from || now.end_time > until) return false;
  return std::max(first - from, until - now.end_time) * speed <= 1.5 * ahead;
}

// Records points on the paths that they follow with their present velocities. New paths begin where
// the recorded ones have been left, or where they are too long for the present speed.
void Snapshot::look_ahead(int body, const BodyPaths& now, const RecordRules& rules, double speed) {
  Body& state = bodies_[body];
  const bool are_new = !state.suit(now, speed, rules.ahead);
  if (are_new) {
    state.from = now.start_time;
    state.until = now.end_time + rules.ahead / speed;
    state.has_paths = false;
  }
  if (start_.empty()) start_ = end_;
  const int first = scene_.bodies[body].first_point;
  for (std::size_t i = 0; i < now.end.size(); ++i) {
    const std::size_t point = first + i;
    const Vec3 rate = now.rate(i), end = now.end_of(i);
    const bool is_still = rate.norm() * (state.until - state.from) <= 0.5 * rules.limit;
    const bool is_asked_for = !rules.others.empty() && rules.others[point] != 0;
    const bool is_kept = state.recorded && displacement_[point] <= rules.limit && !is_asked_for &&
                         (!are_new || (is_still && is_constant(point)));
    if (!is_kept) {
      const Vec3 back = rate * (now.end_time - state.from),
                 ahead = rate * (state.until - now.end_time);
      place(static_cast<int>(point), is_still ? end : end - back, is_still ? end : end + ahead);
      renewed_[point] = 1;
    }
    state.has_paths |= !is_constant(point);
  }
  state.recorded = state.renewed = true;
  measure(body, now);
}

void Snapshot::record_all(int body, const BodyPaths& now, bool with_paths) {
  renew_by_place(body, with_paths);
  const int first = scene_.bodies[body].first_point;
  for (std::size_t i = 0; i < now.end.size(); ++i) {
    const Vec3 end = now.end_of(i);
    place(first + static_cast<int>(i), with_paths ? now.start_of(i) : end, end);
  }
  bodies_[body].recorded = true;
  bodies_[body].from = bodies_[body].until = 0;
  measure(body, now);
}

void Snapshot::renew_by_place(int body, bool has_paths) {
  if (has_paths && start_.empty()) start_ = end_;
  bodies_[body].recorded = false;
  bodies_[body].has_paths = has_paths;
  bodies_[body].renewed = true;
  const auto first = renewed_.begin() + scene_.bodies[body].first_point;
  std::fill_n(first, scene_.bodies[body].point_count(), 1);
}

void Snapshot::place(int point, const Vec3& start, const Vec3& end) {
  end_[point] = end;
  if (!start_.empty()) start_[point] = start;
}

void Snapshot::forget_renewed() {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b].renewed) continue;
    bodies_[b].renewed = false;
    const SceneBody& body = scene_.bodies[b];
    std::fill_n(renewed_.begin() + body.first_point, body.point_count(), 0);
  }
}

}  // namespace weft::sim
