#include "sim/motion/motion_limits.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "sim/case/case_text.h"
#include "sim/scene/scene_curves.h"
#include "sim/scene/sliding_supports.h"

namespace weft::sim {

namespace {

// Largest number of parts into which a body is split to compare distances.
constexpr std::size_t most_blocks = 256;

// Factor by which a step that is too long is shortened.
constexpr double shortening = 0.8;

// Relative margin that exceeds all rounding errors of distances.
constexpr double rounding_part = 1e-9;

bool is_tied_to(const Scene& scene, int body) {
  const auto has_body = [&](const auto& joint) {
    return scene.case_order[joint.body] == body || scene.case_order[joint.to] == body;
  };
  return std::ranges::any_of(scene.ties, has_body) || std::ranges::any_of(scene.seams, has_body);
}

}  // namespace

MotionLimits::MotionLimits(const Scene& scene, const Dynamics& dynamics)
    : scene_(scene),
      dynamics_(dynamics),
      range_(scene.source.contact.enabled ? scene.source.contact.range : 0),
      blocks_(scene.bodies.size()),
      is_bounded_(scene.bodies.size(), 0),
      obstacles_(scene) {
  for (const PrescribedMotion& held : scene.prescribed) {
    if (!held.moves || held.particles.empty()) continue;
    const int body = scene.body_index_of_particle(held.particles.front());
    const bool is_obstacle = !scene.bodies[body].dynamic;
    if (is_obstacle && range_ == 0 && !is_tied_to(scene, body)) continue;
    if (!is_obstacle || range_ > 0)
      motions_.push_back({&held.motion, held.radius, held.particles.front(), body, is_obstacle});
    double time = -1;
    while (const auto event = held.motion.next_event(time)) {
      events_.push_back(*event);
      time = event->time;
    }
  }
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    if (!scene.bodies[b].supports) continue;
    scene.bodies[b].supports->visit_motions([&](const RigidMotion& motion, double radius) {
      motions_.push_back({&motion, radius, scene.bodies[b].first_particle, b, false});
    });
    std::ranges::copy(events_of(*scene.bodies[b].supports), std::back_inserter(events_));
  }
  const SceneCurves curves(scene.source);
  for (const MotionEvent& event : curves.events()) events_.push_back(event);
  for (const Seam& seam : scene.seams) {
    if (seam.source->closing_time > 0) events_.push_back({seam.source->closing_time, false});
  }
  longest_step_ = curves.longest_step();
  if (std::isfinite(scene.pins_change_at)) events_.push_back({scene.pins_change_at, true});
  std::sort(events_.begin(), events_.end(),
            [](const MotionEvent& a, const MotionEvent& b) { return a.time < b.time; });
  if (range_ > 0 && !motions_.empty()) paths_.emplace(scene);
}

double MotionLimits::next_event(double time) const {
  const double after = time + scene_.source.time.minimum_step;
  const auto next = std::upper_bound(events_.begin(), events_.end(), after,
                                     [](double t, const MotionEvent& e) { return t < e.time; });
  return next == events_.end() ? std::numeric_limits<double>::infinity() : next->time;
}

// Returns the events within time.minimum_step of `time`.
std::span<const MotionEvent> MotionLimits::events_at(double time) const {
  const double nearby = scene_.source.time.minimum_step;
  const auto first = std::ranges::lower_bound(events_, time - nearby, {}, &MotionEvent::time);
  const auto last = std::ranges::upper_bound(events_, time + nearby, {}, &MotionEvent::time);
  return {first, last};
}

bool MotionLimits::has_event_at(double time) const { return !events_at(time).empty(); }

bool MotionLimits::jumps_at(double time) const {
  return std::ranges::any_of(events_at(time), &MotionEvent::jumps);
}

// Splits the interval from `time` to `end` into the fewest equal steps that resolve gusts. Returns
// the end of the first one.
double MotionLimits::end_in_gust(double time, double end) const {
  constexpr double rounding = 1e-9;
  const double parts = std::ceil((end - time) / longest_step_ - rounding);
  return parts > 1 ? time + (end - time) / parts : end;
}

std::optional<double> MotionLimits::latest_end(double time, double wanted,
                                               std::span<const double> y) {
  const double latest = end_in_gust(time, std::min(wanted, next_event(time)));
  find_approaches(time, latest, y);
  const double shortest = scene_.source.time.minimum_step;
  double length = latest - time;
  while (!is_short_enough(time, time + length)) {
    if (length <= shortest) return std::nullopt;
    length = std::max(shortest, shortening * length);
  }
  return length == latest - time ? latest : time + length;
}

Failure MotionLimits::failure(double time) const {
  constexpr auto kind = Failure::Kind::prescribed_motion;
  if (crossing_) {
    return {kind, time, crossing_->particle(scene_),
            "prescribed motions leave no room at t = " + rounded_text(time) +
                " s: " + crossing_->describe(scene_)};
  }
  const SceneBody& body = scene_.bodies[culprit_->body];
  return {kind, time, culprit_->particle,
          std::string("the prescribed motion of ") + (body.is_obstacle ? "obstacle" : "body") +
              " \"" + body.name + "\" is too fast to be followed by steps of " +
              number_text(scene_.source.time.minimum_step) +
              " s (time.minimum_step) at t = " + rounded_text(time) + " s"};
}

void MotionLimits::find_approaches(double time, double end, std::span<const double> y) {
  approaches_.clear();
  std::fill(is_bounded_.begin(), is_bounded_.end(), 0);
  bool has_positions = false;
  for (const Moving& moving : motions_) {
    if (!moving.is_obstacle) continue;
    const MotionBounds bounds = moving.motion->bounds(time, end, moving.radius);
    if (bounds.travel <= stray_part * range_) continue;
    if (!has_positions) find_points(time, y);
    has_positions = true;
    for (int body = 0; body < scene_.dynamic_bodies; ++body)
      add_approaches(moving, body, time, end - time, bounds.travel);
  }
}

void MotionLimits::find_points(double time, std::span<const double> y) {
  dynamics_.expand(time, y, position_, velocity_);
  const SurfaceMap& map = scene_.surface_map;
  point_position_ = map.points_of(position_, scene_.dynamic_points, position_room_);
  point_velocity_ = map.points_of(velocity_, scene_.dynamic_points, velocity_room_);
}

// Spheres are points without triangles. Spins have no place.
void MotionLimits::make_blocks(int body) {
  std::vector<Block>& blocks = blocks_[body];
  const SceneBody& from = scene_.bodies[body];
  if (!blocks.empty() || from.are_spins) return;
  const auto& triangles = from.surface_mesh().triangles;
  const bool is_surface = from.spheres == nullptr;
  const std::size_t count =
      is_surface ? triangles.size() : static_cast<std::size_t>(from.point_count());
  const std::size_t each = (count + most_blocks - 1) / most_blocks;
  for (std::size_t first = 0; first < count; first += each) {
    Block& block = blocks.emplace_back();
    for (std::size_t part = first; part < std::min(first + each, count); ++part) {
      if (!is_surface) {
        block.points.push_back(static_cast<int>(part) + from.first_point);
        continue;
      }
      for (const int p : triangles[part]) block.points.push_back(p + from.first_point);
    }
    std::sort(block.points.begin(), block.points.end());
    block.points.erase(std::unique(block.points.begin(), block.points.end()), block.points.end());
  }
}

void MotionLimits::bound_blocks(int body) {
  if (is_bounded_[body] != 0) return;
  is_bounded_[body] = 1;
  make_blocks(body);
  for (Block& block : blocks_[body]) {
    block.box.setEmpty();
    double square = 0;
    for (const int p : block.points) {
      block.box.extend(point_position_[p]);
      square = std::max(square, point_velocity_[p].squaredNorm());
    }
    block.speed = std::sqrt(square);
  }
}

// Sets the box of each block of an obstacle to a box around its start box, moved by the pose at
// `time`.
void MotionLimits::turn_blocks(const RigidObstacle& obstacle, double time) {
  if (is_bounded_[obstacle.body] != 0) return;
  is_bounded_[obstacle.body] = 1;
  const bool is_first = blocks_[obstacle.body].empty();
  make_blocks(obstacle.body);
  pose_ = obstacle.held->motion.pose(time);
  for (Block& block : blocks_[obstacle.body]) {
    if (is_first) {
      for (const int p : block.points)
        block.start.extend(obstacle.start()[p - obstacle.first_point]);
    }
    block.box = box_around(block.start.center(), 0.5 * block.start.sizes(), pose_);
    block.is_placed = false;
  }
}

// Returns the squared distance (m^2) from the box of `block` to the box of the obstacle's nearest
// block. If this distance is at least `enough`, a lower bound that is at least `enough` may be
// returned. Points of a block of the obstacle are placed only if that block may be the nearest.
double MotionLimits::squared_distance(const Block& block, const RigidObstacle& obstacle,
                                      double enough) {
  std::vector<Block>& others = blocks_[obstacle.body];
  distances_.clear();
  for (const Block& other : others)
    distances_.push_back(block.box.squaredExteriorDistance(other.box));
  const auto nearest = std::min_element(distances_.begin(), distances_.end());
  if (*nearest >= enough) return *nearest;
  double square = std::numeric_limits<double>::infinity();
  const auto measure = [&](std::size_t k) {
    Block& other = others[k];
    if (!other.is_placed) {
      other.is_placed = true;
      other.box.setEmpty();
      for (const int p : other.points)
        other.box.extend(pose_.place(obstacle.start()[p - obstacle.first_point]));
    }
    square = std::min(square, block.box.squaredExteriorDistance(other.box));
  };
  measure(nearest - distances_.begin());
  for (std::size_t k = 0; k < others.size(); ++k) {
    if (distances_[k] < square) measure(k);
  }
  return square;
}

// Appends the parts of a body that the obstacle may reach in a step of `length` (s) to approaches_.
void MotionLimits::add_approaches(const Moving& obstacle, int body, double time, double length,
                                  double travel) {
  const RigidObstacle& rigid = obstacles_.all()[obstacles_.of_body(obstacle.body)];
  bound_blocks(body);
  turn_blocks(rigid, time);
  Eigen::AlignedBox3d all;
  for (const Block& other : blocks_[obstacle.body]) all.extend(other.box);
  const double reach =
      range_ + 0.5 * (scene_.bodies[body].thickness + scene_.bodies[obstacle.body].thickness);
  for (const Block& block : blocks_[body]) {
    const double way = block.speed * length + travel;
    if (way <= approach_part * (block.box.exteriorDistance(all) - reach)) continue;
    const double enough = (way / approach_part + reach) * (1 + rounding_part);
    Approach approach{
        .obstacle = &obstacle,
        .clearance = std::sqrt(squared_distance(block, rigid, enough * enough)) - reach,
        .speed = block.speed};
    if (way <= approach_part * approach.clearance) continue;
    for (const int p : block.points) {
      const RigidMotion& motion = *obstacle.motion;
      const Vec3& place = point_position_[p];
      const Vec3 relative = point_velocity_[p] - motion.velocity_at(time, place);
      approach.relative_speed = std::max(approach.relative_speed, relative.norm());
      approach.radius = std::max(approach.radius, motion.distance_from_centre(time, place));
    }
    approaches_.push_back(approach);
  }
}

bool MotionLimits::keeps_to_chord(const Moving& moving, const MotionBounds& bounds) const {
  if (bounds.angle > largest_turn && bounds.angle * moving.radius > 0) return false;
  return range_ == 0 || bounds.stray <= stray_part * range_;
}

bool MotionLimits::is_short_enough(double time, double end) {
  crossing_.reset();
  const double length = end - time;
  for (const Moving& moving : motions_) {
    if (moving.is_obstacle) continue;
    culprit_ = &moving;
    if (!keeps_to_chord(moving, moving.motion->bounds(time, end, moving.radius))) return false;
  }
  for (const Approach& approach : approaches_) {
    culprit_ = approach.obstacle;
    const RigidMotion& motion = *approach.obstacle->motion;
    const MotionBounds bounds = motion.bounds(time, end, approach.obstacle->radius);
    if (bounds.travel <= stray_part * range_) continue;
    const double acceleration = motion.bounds(time, end, approach.radius).acceleration;
    const double way =
        std::min(approach.speed * length + bounds.travel,
                 approach.relative_speed * length + acceleration * length * length / 2);
    if (way <= approach_part * approach.clearance) continue;
    if (way > near_part * range_ || !keeps_to_chord(*approach.obstacle, bounds)) return false;
  }
  if (paths_) crossing_ = paths_->find_crossing(time, end);
  return !crossing_;
}

}  // namespace weft::sim
