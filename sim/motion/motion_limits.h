// Limits of a step's length by the motion of pins and obstacles, which the step must resolve.
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

// Finds the latest end of a step. A step ends at the latest
// - at the next keyframe, start or stop of a motion, or when pins take hold or let go;
// - when a pin has rotated by `largest_turn` or, with contact, strays from its chord by a tenth of
//   contact.range;
// - when an obstacle and a part of a body have used up four fifths of the distance between them
//   that exceeds contact's reach. If that is less than an eighth of contact.range, the step may
//   instead last until they have moved by an eighth of contact.range against each other, or until
//   the obstacle has rotated or strayed as far as a pin may. (The shortest barriers act over a
//   quarter of the range);
// - before pins might pass through an obstacle or through other pins (prescribed_paths.h).
// An obstacle counts by its distance and by the speeds at the start of the step: one that cannot
// come into reach shortens no step. Without contact, obstacles do not count, but for the keyframes,
// starts and stops of those to which a body is tied. Proofs are in
// docs/theory.md, section 2.
class MotionLimits {
 public:
  static constexpr double largest_turn = 0.15;  // rad
  static constexpr double stray_part = 0.1;     // of contact.range
  static constexpr double near_part = 0.125;    // of contact.range: half of the shortest barrier's
  static constexpr double approach_part = 0.8;  // of the distance left
  // Limits are computed for a step longer by this factor, so rounding shortens no step that they
  // allow in full.
  static constexpr double beyond_rounding = 1.0001;

  // Scene and dynamics must outlive the limits.
  MotionLimits(const Scene& scene, const Dynamics& dynamics);

  // False if nothing moves, pins stay as they are and no curve varies: no step is ever shortened.
  bool apply() const {
    return !motions_.empty() || !events_.empty() || std::isfinite(longest_step_);
  }
  // Returns the latest end of a step from `time` and the state `y` that is to end at `wanted`.
  // Returns nothing if even a step of time.minimum_step is too long; failure() then names the
  // motion. Costs a pass over the particles if an obstacle moves, and nothing if only pins do.
  std::optional<double> latest_end(double time, double wanted, std::span<const double> y);
  Failure failure(double time) const;
  // Returns the stop time for an integrator that cuts all coming steps at it. The time is far off
  // if the next step, which should end at `wanted`, need not be shortened.
  static double stop_time(double latest, double wanted) {
    return latest < wanted ? latest : std::numeric_limits<double>::max();
  }
  // Returns the next start, stop, keyframe or corner (s) after `time`; infinite without one. One
  // within the shortest step counts as passed: bounds hold across events.
  double next_event(double time) const;
  // Returns the time (s) that no step from `time` may pass, however long it gets: the next event,
  // or the longest step that follows a gust. SUNDIALS does not tell the length of its next step
  // after one that a stop time has ended, so the length that latest_end() is asked for may be too
  // short.
  double last_possible_end(double time) const;
  // True if a motion starts, stops or passes a keyframe, or a curve has a corner, within
  // time.minimum_step of `time`; and true if a velocity or a curve jumps there.
  bool has_event_at(double time) const;
  bool jumps_at(double time) const;

 private:
  struct Moving {
    const PrescribedMotion* held;
    int body;
    bool is_obstacle;  // of the case, or a body held as a whole
  };
  // A part of a body: the box around some of its triangles.
  struct Block {
    Eigen::AlignedBox3d box;    // of an obstacle: a larger one while is_placed is false
    Eigen::AlignedBox3d start;  // of an obstacle, where its motion starts
    bool is_placed = false;     // of an obstacle: `box` fits
    std::vector<int> points;    // of the surface, global
    double speed = 0;           // the largest, m/s
  };
  // A part of a dynamic body that an obstacle may reach.
  struct Approach {
    const Moving* obstacle;
    double clearance = 0;       // m, to the reach of contact
    double speed = 0;           // of the part, m/s
    double relative_speed = 0;  // against the obstacle, m/s
    double radius = 0;          // of the part's points about the centre of the motion, m
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
  double range_ = 0;  // m; 0 without contact
  std::vector<Moving> motions_;
  std::vector<MotionEvent> events_;         // of motions, pins and curves, by time
  double longest_step_ = 0;                 // s, that follows gusts; infinite without
  std::vector<std::vector<Block>> blocks_;  // by body; boxes are updated in each step
  std::vector<char> is_bounded_;            // by body, in this step
  std::vector<Approach> approaches_;
  std::vector<Vec3> position_, velocity_;
  std::vector<Vec3> position_room_, velocity_room_;        // of points that are no particles
  std::span<const Vec3> point_position_, point_velocity_;  // of the surfaces of dynamic bodies
  RigidObstacles obstacles_;
  RigidPose pose_;                 // of the obstacle in hand
  std::vector<double> distances_;  // m^2, to its blocks
  const Moving* culprit_ = nullptr;
  std::optional<PrescribedPaths> paths_;  // with contact, where something moves
  std::optional<ContactFault> crossing_;  // of the last interval that was checked
};

}  // namespace weft::sim
