#include "sim/contact/snapshot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "materials/lanes.h"
#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

using materials::Lanes;

// Returns an upper bound of the square root of `square` in float32.
float root_above(double square) {
  return static_cast<float>(std::sqrt(square)) * (1 + 2 * std::numeric_limits<float>::epsilon());
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

// Positions (m) to which present paths of the points of a body are compared.
struct EarlierPaths {
  std::span<const Vec3> recorded_start, recorded_end, chosen_start, chosen_end;
};

// The largest squared displacements, m^2.
template <class Real>
struct Largest {
  Real square = 0, from_end = 0, along_path = 0;

  // Adds points from `i` on, and returns their squared displacements since they were recorded.
  Real add(int i, const BodyPaths& now, const EarlierPaths& earlier) {
    const auto at = [&](std::span<const Vec3> points, const Vec3& origin = Vec3::Zero()) {
      return points_at<Real>(points, i, origin);
    };
    const Vector<Real> end = at(now.end, now.end_origin), chosen = at(earlier.chosen_end);
    const Real since_end = squared_distance(end, chosen);
    Real recorded = squared_distance(end, at(earlier.recorded_end));
    from_end = materials::larger(from_end, since_end);
    along_path = materials::larger(along_path, since_end);
    if (now.is_path()) {
      const Vector<Real> start = at(now.start, now.start_origin);
      recorded = materials::larger(recorded, squared_distance(start, at(earlier.recorded_start)));
      from_end = materials::larger(from_end, squared_distance(start, chosen));
      along_path = materials::larger(along_path, squared_distance(start, at(earlier.chosen_start)));
    }
    square = materials::larger(square, recorded);
    return recorded;
  }
};

double largest_lane(Lanes lanes) {
  double largest = 0;
  for (int i = 0; i < materials::lane_count; ++i) largest = std::max(largest, lanes.values[i]);
  return largest;
}

}  // namespace

Snapshot::Snapshot(const Scene& scene, int point_count)
    : scene_(scene),
      bodies_(scene.bodies.size()),
      end_(point_count, Vec3::Zero()),
      chosen_end_(point_count, Vec3::Zero()),
      displacement_(point_count, 0.0F),
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
  const std::span<const Vec3> from = start(body), to = end(body);
  const bool on_paths = now.is_path() && state.chosen_paths;
  const std::span<const Vec3> chosen = of_body(chosen_end_, body),
                              chosen_start = of_body(on_paths ? chosen_start_ : chosen_end_, body);
  float* displacement = displacement_.data() + scene_.bodies[body].first_point;
  const EarlierPaths earlier{from, to, chosen_start, chosen};
  const auto measure_part = [&](int first, int last, Largest<double>& part) {
    Largest<Lanes> lanes;
    int i = first;
    for (; i + materials::lane_count <= last; i += materials::lane_count) {
      const Lanes square = lanes.add(i, now, earlier);
      for (int k = 0; k < materials::lane_count; ++k)
        displacement[i + k] = root_above(square.values[k]);
    }
    for (; i < last; ++i) displacement[i] = root_above(part.add(i, now, earlier));
    part.square = std::max(part.square, largest_lane(lanes.square));
    part.from_end = std::max(part.from_end, largest_lane(lanes.from_end));
    part.along_path = std::max(part.along_path, largest_lane(lanes.along_path));
  };
  Largest<double> largest;
  const int count = static_cast<int>(to.size());
  for (const auto& part : parallel_parts<Largest<double>>(count, scene_.threads, measure_part)) {
    largest.square = std::max(largest.square, part.square);
    largest.from_end = std::max(largest.from_end, part.from_end);
    largest.along_path = std::max(largest.along_path, part.along_path);
  }
  state.displacement = root_above(largest.square);
  if (state.chosen)
    state.since_choice = {root_above(largest.from_end), root_above(largest.along_path)};
}

void Snapshot::choose(int body, const BodyPaths& now) {
  const int first = scene_.bodies[body].first_point;
  const bool has_paths = now.is_path();
  if (has_paths && chosen_start_.empty()) chosen_start_ = chosen_end_;
  for (std::size_t i = 0; i < now.end.size(); ++i) {
    chosen_end_[first + i] = now.end[i] - now.end_origin;
    if (has_paths) chosen_start_[first + i] = now.start[i] - now.start_origin;
  }
  bodies_[body].chosen = true;
  bodies_[body].chosen_paths = has_paths;
  measure(body, now);
}

void Snapshot::renew(int body, const BodyPaths& now, double limit, double short_path,
                     std::span<const char> others) {
  Body& state = bodies_[body];
  double longest = 0;
  if (now.is_path()) {
    for (std::size_t i = 0; i < now.end.size(); ++i) {
      const Vec3 path = now.end[i] - now.end_origin - (now.start[i] - now.start_origin);
      longest = std::max(longest, path.squaredNorm());
    }
  }
  const bool with_paths = longest > short_path * short_path;
  if (!state.recorded || state.has_paths != with_paths) return record_all(body, now, with_paths);
  const int first = scene_.bodies[body].first_point;
  for (std::size_t i = 0; i < now.end.size(); ++i) {
    const std::size_t point = first + i;
    const bool is_asked_for = !others.empty() && others[point] != 0;
    if (!(displacement_[point] > limit) && !is_asked_for) continue;
    const Vec3 end = now.end[i] - now.end_origin;
    place(static_cast<int>(point), with_paths ? now.start[i] - now.start_origin : end, end);
    renewed_[point] = 1;
  }
  state.renewed = true;
  measure(body, now);
}

void Snapshot::record_all(int body, const BodyPaths& now, bool with_paths) {
  renew_by_place(body, with_paths);
  const int first = scene_.bodies[body].first_point;
  for (std::size_t i = 0; i < now.end.size(); ++i) {
    const Vec3 end = now.end[i] - now.end_origin;
    place(first + static_cast<int>(i), with_paths ? now.start[i] - now.start_origin : end, end);
  }
  bodies_[body].recorded = true;
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
