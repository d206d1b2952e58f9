// Finds features that may touch. Candidate lists from the pyramids are kept until bodies may have
// moved into reach.
#pragma once

#include <algorithm>
#include <compare>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bsi/pyramid.h"
#include "sim/base/statistics.h"
#include "sim/contact/body_tree.h"
#include "sim/contact/compute_choice.h"
#include "sim/contact/rigid_obstacles.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// A vertex and a triangle, or two edges, by their indices in the meshes of their bodies.
struct FeaturePair {
  int a = 0;
  int b = 0;
  float distance = 0;  // m, lower bound at the positions where the list was built
};

// Two bodies, a < b, or one body with itself, a == b.
struct BodyPair {
  int a = 0;
  int b = 0;
  // clang-tidy 14 mistakes the generated comparison with 0 for one with a null pointer.
  auto operator<=>(const BodyPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

// The candidates of two bodies, or of one body with itself. Each list is sorted by (a, b), so that
// the order of the pairs in reach does not depend on how the list was found.
struct CandidateList {
  int body_a = 0;
  int body_b = 0;
  double thickness = 0;                      // mean of both bodies, m
  std::vector<FeaturePair> vertex_triangle;  // vertex of a, triangle of b
  std::vector<FeaturePair> triangle_vertex;  // vertex of b, triangle of a; empty for self
  std::vector<FeaturePair> edge_edge;        // edge of a, edge of b; for self a < b
  double drift = 0;  // m, upper bound of the change of any distance since the list was built

  bool is_self() const { return body_a == body_b; }
};

// Returns an empty list for every pair of bodies that may touch, near or far. O(bodies^2).
std::vector<CandidateList> searched_pairs(const Scene& scene);
// Returns an empty list for every pair of bodies whose boxes at the start are within thickness +
// range + slack of each other.
std::vector<CandidateList> neighbours_at_start(const Scene& scene);
// Returns the distance (m) by which lists reach beyond thickness + range.
double search_slack(const Scene& scene);

// Keeps the candidate lists of all pairs of bodies that may touch. The lists contain every pair of
// features closer than thickness + range at the positions last passed to update(). They are built
// with a slack and remain valid until the bodies have moved by that distance. Translations of a
// whole body (within one body) and common translations (of two bodies) do not count as motion.
//
// Every body has a box that is larger than necessary. Pairs whose boxes do not meet have no list
// and are not visited. A body that leaves its box gets a new box and, from a tree, new neighbours.
// If the bounding spheres of two neighbours are farther apart than their list reaches, the list
// stays empty until the bodies might have met.
//
// Obstacles that move as rigid bodies may be given by their poses, which bound their positions and
// displacements. Their vertices are placed only where lists are built from them.
//
// Pairs whose points all follow prescribed paths are left out, because no force could separate
// them.
class ContactSearch {
 public:
  ContactSearch(const Scene& scene, Statistics& statistics, ChosenSearch search);

  // Makes the lists complete at these positions of all surface points, m. Returns a point whose
  // position is not finite, if any.
  [[nodiscard]] std::optional<int> update(const PlacedPoints& now);
  [[nodiscard]] std::optional<int> update(std::span<const Vec3> position) {
    return update(PlacedPoints(position));
  }
  // Makes the lists complete all along the straight paths start -> end, m, and along all paths that
  // deviate from these by at most `stray` (m, by body; empty: zero). Returns as update() does.
  [[nodiscard]] std::optional<int> update_path(const PlacedPoints& start, const PlacedPoints& end,
                                               std::span<const double> stray = {});
  [[nodiscard]] std::optional<int> update_path(std::span<const Vec3> start,
                                               std::span<const Vec3> end,
                                               std::span<const double> stray = {}) {
    return update_path(PlacedPoints(start), PlacedPoints(end), stray);
  }

  // Returns the lists of neighbours, sorted by (body_a, body_b).
  std::span<const CandidateList> lists() const { return lists_; }
  const RigidObstacles& obstacles() const { return obstacles_; }
  double slack() const { return slack_; }
  // Returns the device that runs the search. It changes at most once: if a device fails, the CPU
  // continues, with the same results.
  const ComputeChoice& compute() const { return search_.choice; }

 private:
  // The displacement of a body since a snapshot, m: |x - x_snapshot - mean| <= residual for all its
  // points.
  struct Displacement {
    Vec3 mean{0, 0, 0};
    double residual = 0;
    double largest() const { return mean.norm() + residual; }
  };
  using Box = BodyTree::Box;
  struct Tracked {
    // Positions at which the lists were built, or those at the end of the path for which they were
    // built. Empty for a body that does not move or has never had a list.
    std::vector<Vec3> snapshot;
    std::vector<Vec3> path_start;  // start of that path; empty if there was none
    // Poses of a rigid obstacle in place of `snapshot` and `path_start`, if it was given by its
    // pose.
    std::optional<RigidPose> pose, path_start_pose;
    double path_length = 0;  // m, sum of the displacements between earlier snapshots
    Displacement now;        // at the end of the present path
    Displacement at_start;   // at the start of that path; without a path, equal to `now`
    double largest() const { return std::max(now.largest(), at_start.largest()); }
    Box box;           // around its present points or paths, without the stray
    double stray = 0;  // m, largest deviation of its points from the present path
    bool pyramid_built = false;
    bsi::Sphere
        bounds;  // around the body at its snapshot or all along its path; radius < 0 while unset
  };
  struct ListState {
    bool near = false;  // true: built from the pyramids; false: excluded by the bounding spheres
    bool built = false;
    double clearance = 0;    // m, path length of both bodies within which the pair stays excluded
    double path_length = 0;  // m, of both bodies when the pair was excluded
    double stray = 0;        // m, stray of both bodies for which the list was built
  };

  std::span<const Vec3> of_body(std::span<const Vec3> all, int body) const;
  // Finds the displacements of all moving bodies since their snapshots or, with `from_start`, since
  // the starts of their paths. Extends the bodies' boxes by the positions. Returns a point whose
  // position is not finite, if any.
  std::optional<int> track(const PlacedPoints& now, bool from_start = false);
  bool track_pose(const RigidObstacle& obstacle, const PlacedPoints& now, bool from_start);
  bool track_points(int body, std::span<const Vec3> now, bool from_start);
  void fill_snapshot(const RigidObstacle& obstacle);
  static Displacement displacement(std::span<const Vec3> snapshot, std::span<const Vec3> now);
  static Displacement displacement(const RigidObstacle& obstacle, const RigidPose& snapshot,
                                   const RigidPose& now);
  std::optional<int> find_lost(std::span<const Vec3> position, int body) const;
  // Gives new boxes to bodies that have left theirs, and updates the lists accordingly.
  void find_neighbours(std::span<const Vec3> position);
  void place_all(std::span<const Vec3> position);
  Box needed_box(int body) const;
  Box enlarged_box(int body) const;
  void replace_lists(std::span<const int> placed);
  void merge_lists(std::span<const BodyPair> pairs);
  ListState first_state(const CandidateList& list);
  double stray(const CandidateList& list) const;
  double drift(const CandidateList& list) const;
  static double drift(const CandidateList& list, const Displacement& a, const Displacement& b);
  bool is_valid(std::size_t list) const;
  bool are_valid() const;
  std::vector<char> bodies_to_refresh() const;
  void refresh(const PlacedPoints& start, const PlacedPoints& end);
  void rebuild_lists(const PlacedPoints& start, const PlacedPoints& end);
  void refresh_body(int body, const PlacedPoints& start, const PlacedPoints& end);
  bool rule_out(std::size_t list);
  BodyPath path_of(int body, const PlacedPoints& start, const PlacedPoints& end) const;
  void rebuild_pyramids(const PlacedPoints& start, const PlacedPoints& end);
  void find_quad_pairs(const PlacedPoints& start, const PlacedPoints& end);
  void place_found(const PlacedPoints& start, const PlacedPoints& end);
  void build_lists(const PlacedPoints& start, const PlacedPoints& end);
  double reach(const CandidateList& list) const {
    return list.thickness + range_ + slack_ + stray(list);
  }

  const Scene& scene_;
  Statistics& statistics_;
  double range_ = 0;
  double slack_ = 0;
  RigidObstacles obstacles_;
  PlacedMarks marks_;
  std::vector<Tracked> tracked_;
  std::vector<int> moving_;   // bodies
  BodyTree tree_;             // of boxes enlarged by room to move and half of the reach
  std::vector<char> placed_;  // by body: nonzero if it got a new box in this update
  std::vector<CandidateList> lists_;
  std::vector<ListState> states_;  // by list
  ChosenSearch search_;
  // The lists in progress, their queries and the quad pairs found.
  std::vector<std::size_t> building_;
  std::vector<PairQuery> queries_;
  std::vector<std::vector<bsi::LeafPair>> quad_pairs_;
};

}  // namespace weft::sim
