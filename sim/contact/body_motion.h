// The positions of bodies, and their motion since candidate lists were made.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "sim/contact/body_tree.h"
#include "sim/contact/pair_search.h"
#include "sim/contact/rigid_obstacles.h"
#include "sim/contact/snapshot.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The straight paths of all surface points, m. Both ends are the same list if nothing moves.
struct PointPaths {
  PlacedPoints start, end;
  bool is_path() const { return !start.is_same(end); }
};

// Upper bounds (m) of the displacements of features of one kind since their record.
struct FeatureMotion {
  std::span<const float> each;  // by feature of the body; empty if `largest` stands for each
  float largest = 0;            // bounds all of them
  float operator[](int feature) const { return each.empty() ? largest : each[feature]; }
};

// Positions and motions of the bodies of a contact search. Two snapshots of the points serve two
// kinds of candidate lists: `placed` those of two bodies, `own` those of a body with itself. The
// latter is relative to the mean of the points of each body. Rigid obstacles that are given by
// their poses have no points in `placed`, but the poses at which they were recorded.
class BodyMotion {
 public:
  using Box = BodyTree::Box;

  explicit BodyMotion(const Scene& scene);

  const RigidObstacles& obstacles() const { return obstacles_; }
  std::span<const int> moving() const { return moving_; }  // indices of the bodies that move

  // Sets the present paths of all points, from which they deviate by at most `stray` (m, by body;
  // empty: zero). If a point of a moving body is not finite or is extremely far away (1e15 m),
  // returns its index. `velocity` contains the velocities of all points, m/s, or is empty; for
  // paths, it is not used. Both lists must stay valid until the next call.
  [[nodiscard]] std::optional<int> follow(const PointPaths& paths, std::span<const double> stray,
                                          std::span<const Vec3> velocity = {});
  // Returns the box around a body's present points or paths, without stray, m.
  const Box& box(int body) const { return bodies_[body].box; }
  double stray(int body) const { return bodies_[body].stray; }

  BodyPaths present(int body) const { return placed_paths(body); }

  // Find the displacements of a body's points since its records. `with_mean` also finds the mean
  // displacement.
  void measure_placed(int body, bool with_mean);
  void measure_own(int body) { own_.measure(body, own_paths(body)); }
  // Return upper bounds (m) of the change of any distance within a body, or between two bodies,
  // since they were recorded, without stray. Infinite if a body has not been recorded. Precondition
  // of the second: measure_placed() of both bodies, with the mean if both move.
  double own_change(int body) const { return 2 * own_.displacement(body); }
  double change(int a, int b) const;

  // Bound the displacements of a body's features since its records, and remember the bounds.
  // Precondition: the body moves and has been recorded.
  void choose_placed(int body);
  void choose_own(int body);
  // Return upper bounds (m) of how much the sum of the displacements of any two features since
  // their records has grown since the choice.
  double own_growth(int body) const { return 2 * own_.growth(body); }
  double growth(int a, int b) const { return growth(a) + growth(b); }

  // Records points of a body, as Snapshot::renew() does. A rigid obstacle is recorded as a whole. A
  // body with lists of other bodies that move does not look ahead, because all points of a list are
  // expected at the same part of their paths.
  void renew_placed(int body, const RecordRules& rules);
  void renew_own(int body, const RecordRules& rules);
  const Snapshot& placed() const { return placed_; }
  const Snapshot& own() const { return own_; }
  void forget_renewed();
  // Return the paths of a body for a pyramid around its record. `with_points` places all points of
  // a rigid obstacle, too.
  BodyPath placed_path(int body, bool with_points);
  BodyPath own_path(int body) const { return {body, own_.start(body), own_.end(body), true}; }
  // Computes the recorded positions of a quad's corners on a rigid obstacle that is given by its
  // pose.
  void place_quad(int body, int quad);
  bool is_posed(int body) const { return bodies_[body].pose.has_value(); }
  void begin_placing() { marks_.begin(scene_.point_count); }

  enum class Feature { vertex, triangle, edge };
  // Returns bounds of the displacements of a body's features since its records, for lists of the
  // body with itself or with others. Valid for the paths of the last choice.
  FeatureMotion features(int body, Feature kind, bool own) const;

 private:
  // The displacement of a body since its record. All its points satisfy |x - x_recorded - mean| <=
  // residual.
  struct Displacement {
    Vec3 mean{0, 0, 0};
    double residual = 0;
    double largest() const { return mean.norm() + residual; }
  };
  struct Features {
    std::vector<float> bounds[3];  // m, by Feature, then by feature of the body
    float largest = 0;
  };
  struct Body {
    Displacement at_start, at_end;  // at both ends of the present path, since the record in placed_
    double moved = 0;  // m, upper bound of the displacement of any of its points since that record
    bool with_mean = false;                       // true if mean displacements are needed
    Vec3 start_middle{0, 0, 0}, middle{0, 0, 0};  // m, means of its points at the ends of the path
    // The poses that replace the record of a rigid obstacle in placed_. There is no start_pose
    // without a path.
    std::optional<RigidPose> pose, start_pose;
    // m, `moved` of a rigid obstacle at the last choice
    double chosen = std::numeric_limits<double>::infinity();
    Box box;
    double stray = 0;
    Features placed, own;  // since the records in placed_ and own_
  };

  std::span<const Vec3> of_body(std::span<const Vec3> all, int body) const;
  std::optional<int> enclose(const PlacedPoints& now);
  std::optional<int> find_lost(std::span<const Vec3> position, int body) const;
  const RigidObstacle* posed(int body) const;
  BodyPaths placed_paths(int body) const;
  BodyPaths own_paths(int body) const;
  void find_means(int body);
  double growth(int body) const;
  static Displacement displacement(std::span<const Vec3> recorded, std::span<const Vec3> now);
  static Displacement displacement(const RigidObstacle& obstacle, const RigidPose& recorded,
                                   const RigidPose& now);
  void find_features(int body, const Snapshot& snapshot, Features& found) const;

  const Scene& scene_;
  RigidObstacles obstacles_;
  std::vector<int> moving_;
  std::vector<Body> bodies_;
  std::optional<PointPaths> paths_;  // of the last follow()
  std::span<const Vec3> velocity_;   // as given to it
  double time_before_ = 0;           // s, end of the paths before, if it was no later
  Snapshot placed_, own_;
  PlacedMarks marks_;
};

}  // namespace weft::sim
