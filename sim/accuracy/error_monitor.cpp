#include "sim/accuracy/error_monitor.h"
#include "sim/case/time_methods.h"
#include "sim/motion/dynamics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace weft::sim {

namespace {

constexpr double tolerance_factor = 64;

// Differences between runs up to this fraction of a body's motion or size are small: they grow in
// proportion to the errors that caused them.
constexpr double small_part = 0.1;

std::unique_ptr<const Scene> scene_with(const Scene& scene, const TimeCase& time) {
  Case source = scene.source;
  source.time = time;
  return build_scene(source);
}

std::span<const Vec3> of_body(const SceneBody& body, std::span<const Vec3> all) {
  return all.subspan(body.first_particle, body.particle_count());
}

double rms_radius(std::span<const Vec3> points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& point : points) mean += point / static_cast<double>(points.size());
  return rms_distance(points, std::vector<Vec3>(points.size(), mean));
}

}  // namespace

double rms_distance(std::span<const Vec3> a, std::span<const Vec3> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TimeCase tightened(const TimeCase& time) {
  assert(!traits_of(time.method).finds_equilibria());
  TimeCase result = time;
  const bool is_first_order = traits_of(time.method).order == 1;
  if (!time.step && is_first_order) result.method = TimeMethod::cvode;
  const double step_factor =
      std::pow(tolerance_factor, is_first_order && time.step ? 1.0 / 2 : 1.0 / 3);
  result.position_tolerance /= tolerance_factor;
  result.relative_tolerance /= tolerance_factor;
  if (result.velocity_tolerance) *result.velocity_tolerance /= tolerance_factor;
  result.minimum_step /= step_factor;
  if (result.step) *result.step /= step_factor;
  if (result.maximum_step) *result.maximum_step /= step_factor;
  return result;
}

ErrorMonitor::ErrorMonitor(const Scene& scene, const std::atomic<int>* stop)
    : ErrorMonitor(scene, tightened(scene.source.time),
                   [stop](const Simulation&) { return stop != nullptr && *stop != 0; }) {}

ErrorMonitor::ErrorMonitor(const Scene& scene, const TimeCase& second, ShouldStop should_stop)
    : simulation_(scene_with(scene, second)),
      should_stop_(std::move(should_stop)),
      state_(simulation_.state().begin(), simulation_.state().end()),
      distances_(static_cast<std::size_t>(scene.dynamic_bodies)),
      motion_(distances_.size()) {
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    radius_.push_back(rms_radius(of_body(scene.bodies[b], scene.initial_position)));
  }
}

std::span<const double> ErrorMonitor::compare(double time, std::span<const double> y) {
  if (advance(time)) {
    const Dynamics& dynamics = simulation_.dynamics();
    dynamics.expand(time, state_, position_, scratch_velocity_);
    dynamics.expand(time, y, other_position_, scratch_velocity_);
    measure(time);
  } else {
    std::fill(distances_.begin(), distances_.end(), std::numeric_limits<double>::quiet_NaN());
  }
  return distances_;
}

bool ErrorMonitor::advance(double time) {
  while (failure_.empty() && simulation_.time() < time) {
    if (should_stop_ && should_stop_(simulation_)) return false;
    if (const auto failure = simulation_.step()) failure_ = failure->text;
  }
  if (!failure_.empty()) return false;
  if (time > 0) {
    if (const auto failure = simulation_.state_at(time, state_)) failure_ = failure->text;
  }
  return failure_.empty();
}

void ErrorMonitor::measure(double time) {
  times_.push_back(time);
  for (std::size_t b = 0; b < distances_.size(); ++b) {
    const SceneBody& body = simulation_.scene().bodies[b];
    const auto now = of_body(body, position_);
    distances_[b] = rms_distance(now, of_body(body, other_position_));
    all_distances_.push_back(distances_[b]);
    motion_[b] = std::max(motion_[b],
                          rms_distance(now, of_body(body, simulation_.scene().initial_position)));
  }
}

void ErrorMonitor::transfer(StateArchive& archive, std::string& simulation) {
  archive(simulation, distances_, motion_, times_, all_distances_, failure_);
}

std::string ErrorMonitor::checkpoint() {
  StateArchive archive;
  std::string simulation = simulation_.checkpoint();
  transfer(archive, simulation);
  return archive.bytes();
}

void ErrorMonitor::restore(std::string_view bytes) {
  StateArchive archive(bytes);
  std::string simulation;
  transfer(archive, simulation);
  simulation_.restore(simulation);
}

ErrorEstimate ErrorMonitor::estimate() const {
  ErrorEstimate result;
  result.failure = failure_;
  for (int b = 0; b < simulation_.scene().dynamic_bodies; ++b)
    result.bodies.push_back({simulation_.scene().bodies[b].name});
  const double* distance = all_distances_.data();
  for (const double time : times_) {
    result.last_time = time;
    for (std::size_t b = 0; b < result.bodies.size(); ++b, ++distance) {
      BodyError& error = result.bodies[b];
      error.last = *distance;
      if (*distance > error.largest) {
        error.largest = *distance;
        error.largest_time = time;
      }
      const bool small = *distance <= small_part * std::min(motion_[b], radius_[b]);
      if (!small && !result.parted_time) result.parted_time = time;
    }
  }
  return result;
}

}  // namespace weft::sim
