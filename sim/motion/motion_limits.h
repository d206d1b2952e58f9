// Limits the length of steps, so that they resolve the motion of pins and obstacles.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/failure.h"
#include "sim/motion/dynamics.h"
#include "sim/motion/prescribed_paths.h"

namespace weft::sim {

// Finds the latest end of a step. A step ends no later than the first of these times:
// - the next event: a keyframe, start or stop of a motion, a corner of a curve, or a change of
//   pins;
// - the end of the longest step that resolves gusts;
// - the time at which a pin has rotated by `largest_turn`, or with contact strays from its chord by
//   `stray_part` of contact.range;
// - the time at which an obstacle and a part of a body have approached by `approach_part` of their
//   clearance, the distance in excess of contact's reach. Beyond this time, a relative motion of up
//   to `near_part` of contact.range is still allowed, within the bounds that apply to pins;
// - the time up to which the paths of pins provably do not cross obstacles or other pins
//   (prescribed_paths.h).
//
// The speeds at the start of the step bound the approach of an obstacle. An obstacle that cannot
// come into reach limits steps only by its events. Without contact, obstacles limit steps only by
// events, and only if a body is tied to them. Proofs are in docs/theory.md, section 2.
class MotionLimits {
 public:
  static constexpr double largest_turn = 0.15;  // rad
  static constexpr double stray_part = 0.1;     // fraction of contact.range
  // Fraction of contact.range: half the shortest barrier.
  static constexpr double near_part = 0.125;
  static constexpr double approach_part = 0.8;  // fraction of the clearance
  // Factor for the step that an integrator passes to latest_end(). With this margin, rounding never
  // shortens a step that is allowed in full.
  static constexpr double beyond_rounding = 1.0001;

  // Scene and dynamics must outlive the limits.
  MotionLimits(const Scene& scene, const Dynamics& dynamics);

  // True if a motion, a change of pins or a curve may shorten steps.
  bool apply() const {
    return !motions_.empty() || !events_.empty() || std::isfinite(longest_step_);
  }
  // Returns the latest end (s) of a step that starts at (time, y) and should end at `wanted`.
  // Returns nothing if even a step of time.minimum_step is too long; failure() then names the
  // motion. Cost: a pass over the particles if an obstacle moves and, with contact, one or more
  // calls of PrescribedPaths::find_crossing().
  std::optional<double> latest_end(double time, double wanted, std::span<const double> y);
  Failure failure(double time) const;
  // Returns the stop time for an integrator that cuts its steps at a stop time. This is `latest` if
  // it is before `wanted`, else the largest number.
  static double stop_time(double latest, double wanted) {
    return latest < wanted ? latest : std::numeric_limits<double>::max();
  }
  // Returns the time (s) of the next event after `time`: a start, stop, keyframe, corner or change
  // of pins. The result is infinite if no event follows. Events within time.minimum_step after
  // `time` count as passed, because the bounds of motions hold across events.
  double next_event(double time) const;
  // has_event_at() is true if an event (next_event()) is within time.minimum_step of `time`.
  // jumps_at() is true if a prescribed velocity or a curve jumps, or pins change, at such an event.
  bool has_event_at(double time) const;
  bool jumps_at(double time) const;

 private:
  struct Moving {
    const RigidMotion* motion;
    double radius;  // RigidMotion::radius_of() the particles that move, m
    int particle;   // one of them
    int body;
    bool is_obstacle;  // true for an obstacle of the case or a body held as a whole
  };
  // A part of a body: some of its triangles or spheres, and the box around their points.
  struct Block {
    // Box (m) around the points. For an obstacle, it may be larger while is_placed is false.
    Eigen::AlignedBox3d box;
    Eigen::AlignedBox3d start;  // box (m) of an obstacle before the motion
    bool is_placed = false;     // true if `box` is the smallest box around the points
    std::vector<int> points;    // surface points of the part, by their indices in the scene
    double speed = 0;           // largest speed of its points (m/s)
  };
  // A part of a dynamic body that an obstacle may reach.
  struct Approach {
    const Moving* obstacle;
    double clearance = 0;       // distance in excess of contact's reach (m)
    double speed = 0;           // largest speed of its points (m/s)
    double relative_speed = 0;  // largest speed of its points relative to the obstacle (m/s)
    double radius = 0;          // largest distance of its points from the centre of the motion (m)
  };
  std::span<const MotionEvent> events_at(double time) const;
  double end_in_gust(double time, double end) const;
  void find_approaches(double time, double end, std::span<const double> y);
  void add_approaches(const Moving& obstacle, int body, double time, double length, double travel);
  void find_points(double time, std::span<const double> y);
  void make_blocks(int body);
  void bound_blocks(int body);
  void turn_blocks(const RigidObstacle& obstacle, double time);
  double squared_distance(const Block& block, const RigidObstacle& obstacle, double enough);
  bool is_short_enough(double time, double end);
  bool keeps_to_chord(const Moving& moving, const MotionBounds& bounds) const;

  const Scene& scene_;
  const Dynamics& dynamics_;
  double range_ = 0;  // contact.range (m); 0 without contact
  std::vector<Moving> motions_;
  std::vector<MotionEvent> events_;  // events of motions, pins and curves, sorted by time
  double longest_step_ = 0;          // longest step that resolves gusts (s); infinite without gusts
  std::vector<std::vector<Block>> blocks_;  // parts of each body; boxes are updated in each step
  // For each body, 1 if the boxes of its parts are those of this step.
  std::vector<char> is_bounded_;
  std::vector<Approach> approaches_;
  std::vector<Vec3> position_, velocity_;
  // Storage of positions and velocities of surface points that are not particles.
  std::vector<Vec3> position_room_, velocity_room_;
  // Views of the positions and velocities of surface points of dynamic bodies.
  std::span<const Vec3> point_position_, point_velocity_;
  RigidObstacles obstacles_;
  RigidPose pose_;                 // pose of the obstacle last passed to turn_blocks()
  std::vector<double> distances_;  // scratch: squared distances (m^2) to the parts of an obstacle
  const Moving* culprit_ = nullptr;
  std::optional<PrescribedPaths> paths_;  // present with contact, if pins or obstacles move
  std::optional<ContactFault> crossing_;  // crossing found in the last interval checked
};

}  // namespace weft::sim
