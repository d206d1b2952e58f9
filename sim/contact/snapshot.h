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
  bool is_path() const { return start.data() != end.data(); }
};

// Upper bounds of the displacements (m) of all points of a body since its paths were chosen. The
// change of any distance is no larger than the sum of both bodies' bounds of the same kind.
struct SinceChoice {
  double from_end = std::numeric_limits<double>::infinity();  // from the ends of the chosen paths
  // At equal times on the present paths and the chosen ones. The same as from_end where the
  // present points rest, or the chosen ones did.
  double along_path = std::numeric_limits<double>::infinity();
};

// A snapshot records positions, or straight paths, of the surface points of bodies. Points are
// recorded one by one: a point that has moved far gets a new position in the snapshot, and the
// other points keep theirs. Candidate lists contain the pairs of features that are near each other
// in the snapshot. The distance of two features differs from that in the snapshot by no more than
// the displacements of both since, whenever their points were recorded.
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
  // Remembers the present paths of a body's points. Later calls of measure() also bound the
  // displacements from there.
  void choose(int body, const BodyPaths& now);
  const SinceChoice& since_choice(int body) const { return bodies_[body].since_choice; }

  // Records the points of the body that have moved farther than `limit` (m) or have a mark in
  // `others` (by point; empty: none), and marks them. They are recorded with their paths if one of
  // the body's paths is longer than `short_path` (m), at the ends of their paths otherwise. If that
  // is not so for the points recorded before, all points are recorded. Precondition: measure(body,
  // now).
  void renew(int body, const BodyPaths& now, double limit, double short_path,
             std::span<const char> others = {});
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
    SinceChoice since_choice;
    bool chosen = false, chosen_paths = false;
  };
  std::span<const Vec3> of_body(std::span<const Vec3> all, int body) const;
  void record_all(int body, const BodyPaths& now, bool with_paths);

  const Scene& scene_;
  std::vector<Body> bodies_;
  std::vector<Vec3> start_, end_;                // m; start_ is empty until a point has a path
  std::vector<Vec3> chosen_start_, chosen_end_;  // m; the first is empty until a path is chosen
  std::vector<float> displacement_;
  std::vector<char> renewed_;
};

}  // namespace weft::sim
