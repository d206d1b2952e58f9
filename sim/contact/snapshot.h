// Positions from which candidate lists are made, and bounds of the motion since.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Straight paths of the points of one body, m. Both ends are the same list if the points rest.
// `start_origin` and `end_origin` are subtracted from the positions.
struct BodyPaths {
  std::span<const Vec3> start, end;
  Vec3 start_origin{0, 0, 0}, end_origin{0, 0, 0};
  // The times at both ends, s. For points that rest, `start_time` may be earlier: they are likely
  // to be compared with paths from that time on.
  double start_time = 0, end_time = 0;
  // Velocities of points that rest, m/s, and a velocity subtracted from them. Empty if unknown.
  std::span<const Vec3> velocity = {};
  Vec3 velocity_origin{0, 0, 0};

  bool is_path() const { return start.data() != end.data(); }
  Vec3 start_of(std::size_t i) const { return start[i] - start_origin; }
  Vec3 end_of(std::size_t i) const { return end[i] - end_origin; }
  // Returns the velocity of a point (m/s), or zero if nothing tells it.
  Vec3 rate(std::size_t i) const;
};

// Which points Snapshot::renew() records, and how.
struct RecordRules {
  double limit = 0;       // m: points that have moved farther are recorded
  double short_path = 0;  // m: paths no longer than this are recorded at their ends
  // m: the length, as a root mean square, of the paths on which points are expected after the
  // present ones. No path goes on for more than three times as long. If it is zero, points are
  // expected to rest.
  double ahead = 0;
  std::span<const char> others = {};  // by point: nonzero if it is recorded anyway; empty: none
};

// A snapshot records positions, or straight paths, of the surface points of bodies. Points are
// recorded one by one: a point that has moved far gets a new position in the snapshot, and the
// other points keep theirs. Candidate lists contain the pairs of features that are near each other
// in the snapshot. The distance of two features differs from that in the snapshot by no more than
// the displacements of both since, whenever their points were recorded.
//
// A body may look ahead: its points are then recorded on the paths that they will follow with their
// present velocities, and displacements are measured from the positions that are expected at the
// present time. All points of a body are expected at the same part of their paths. Any part gives
// a true bound; the time only selects one that gives a small bound.
class Snapshot {
 public:
  // For the first `point_count` points of the scene. Nothing is recorded yet.
  Snapshot(const Scene& scene, int point_count);

  // Returns true if the points of the body have been recorded.
  bool has(int body) const { return bodies_[body].recorded; }
  bool has_paths(int body) const { return bodies_[body].has_paths; }
  // start() and end() return the recorded positions of all points at the ends of their paths, m.
  // Both are the same list if no point has a path.
  std::span<const Vec3> start() const { return start_.empty() ? end_ : start_; }
  std::span<const Vec3> end() const { return end_; }
  std::span<const Vec3> start(int body) const {
    return of_body(has_paths(body) ? start_ : end_, body);
  }
  std::span<const Vec3> end(int body) const { return of_body(end_, body); }

  // Finds the displacements of a body's points from their recorded positions to `now`, as long as
  // they follow straight paths. These are largest at one end of a path. Sets them to infinity if
  // the body has not been recorded. O(points).
  void measure(int body, const BodyPaths& now);
  // Returns an upper bound of the displacements of the body's points at the last measure(), m.
  double displacement(int body) const { return bodies_[body].displacement; }
  // Returns an upper bound of the displacement of each point, m.
  std::span<const float> displacements() const { return displacement_; }
  // Remembers the displacements of the body's points at the last measure().
  void choose(int body);
  // Returns an upper bound (m) of how much the displacement of any point of the body has grown
  // since the last choose(), or infinity before the first.
  double growth(int body) const { return bodies_[body].growth; }

  // Records the points of the body that have moved farther than the limit, or are asked for, and
  // marks them. Without velocities, where points move far in one step, or if the rules do not look
  // ahead, points are recorded with their present paths if one of these is longer than
  // `short_path`, at the ends of their paths otherwise. If that is not so for the points recorded
  // before, all points are recorded. A body that looks ahead has all its points recorded when the
  // time leaves the recorded paths, except those that stay where they are. Precondition:
  // measure(body, now).
  void renew(int body, const BodyPaths& now, const RecordRules& rules);
  bool looks_ahead(int body) const { return bodies_[body].looks_ahead(); }
  // Drops the records of a body.
  void forget(int body) { bodies_[body].recorded = false; }
  // Marks all points of a body, whose positions place() gives where they are needed. The body
  // counts as not recorded.
  void renew_by_place(int body, bool has_paths);
  void place(int point, const Vec3& start, const Vec3& end);
  // Returns one mark per point, nonzero if it was recorded since the last forget_renewed().
  std::span<const char> renewed() const { return renewed_; }
  bool is_renewed(int body) const { return bodies_[body].renewed; }
  void forget_renewed();

 private:
  struct Body {
    bool recorded = false, has_paths = false, renewed = false;
    double displacement = 0;
    double growth = std::numeric_limits<double>::infinity();
    // The times at both ends of the recorded paths, s. Both are the same unless it looks ahead.
    double from = 0, until = 0;
    bool looks_ahead() const { return until > from; }
    // Returns the part of the recorded paths that belongs to a time.
    double part_at(double time) const;
    bool suit(const BodyPaths& now, double speed, double ahead) const;
  };
  std::span<const Vec3> of_body(std::span<const Vec3> all, int body) const;
  void record_all(int body, const BodyPaths& now, bool with_paths);
  void look_ahead(int body, const BodyPaths& now, const RecordRules& rules, double speed);
  bool is_constant(std::size_t point) const {
    return start_.empty() || start_[point] == end_[point];
  }

  const Scene& scene_;
  std::vector<Body> bodies_;
  std::vector<Vec3> start_, end_;             // m; start_ is empty until a point has a path
  std::vector<float> displacement_, chosen_;  // m, by point, now and at the last choose()
  std::vector<char> renewed_;
};

}  // namespace weft::sim
