#include "sim/contact/snapshot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

// Returns an upper bound of the square root of `square` in float32.
float root_above(double square) {
  return static_cast<float>(std::sqrt(square)) * (1 + 2 * std::numeric_limits<float>::epsilon());
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
  struct Largest {
    double square = 0, from_end = 0, along_path = 0;
  };
  const auto measure_part = [&](int first, int last, Largest& part) {
    for (int i = first; i < last; ++i) {
      const Vec3 at_end = now.end[i] - now.end_origin;
      double square = (at_end - to[i]).squaredNorm();
      const double since_end = (at_end - chosen[i]).squaredNorm();
      part.from_end = std::max(part.from_end, since_end);
      part.along_path = std::max(part.along_path, since_end);
      if (now.is_path()) {
        const Vec3 at_start = now.start[i] - now.start_origin;
        square = std::max(square, (at_start - from[i]).squaredNorm());
        part.from_end = std::max(part.from_end, (at_start - chosen[i]).squaredNorm());
        part.along_path = std::max(part.along_path, (at_start - chosen_start[i]).squaredNorm());
      }
      displacement[i] = root_above(square);
      part.square = std::max(part.square, square);
    }
  };
  Largest largest;
  const int count = static_cast<int>(to.size());
  for (const Largest& part : parallel_parts<Largest>(count, scene_.threads, measure_part)) {
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
