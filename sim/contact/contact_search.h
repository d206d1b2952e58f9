// Finds pairs of features that may touch. Lists of candidates are reused until bodies may have
// moved so far that the lists are incomplete.
#pragma once

#include <algorithm>
#include <compare>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bsi/detail/neighbourhoods.h"
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
  // Lower bound (m) of the distance, at the positions or along the paths for which the list was
  // built.
  float distance = 0;
};

// Two bodies, a < b, or one body with itself, a == b.
struct BodyPair {
  int a = 0;
  int b = 0;
  // clang-tidy 14 mistakes the generated comparison with 0 for one with a null pointer.
  auto operator<=>(const BodyPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

// The candidates of two bodies, or of one body with itself. Each list is sorted by (a, b), so that
// the order does not depend on the processor that found the pairs.
struct CandidateList {
  int body_a = 0;
  int body_b = 0;
  double thickness = 0;                      // mean thickness of both bodies, m
  std::vector<FeaturePair> vertex_triangle;  // vertex of body_a, triangle of body_b
  std::vector<FeaturePair> triangle_vertex;  // vertex of body_b, triangle of body_a; empty for self
  std::vector<FeaturePair> edge_edge;        // edges of body_a and body_b; for self a < b
  // Pairs of neighbours at rest within one body. They are not in contact at any distance, but must
  // not pass through each other.
  std::vector<FeaturePair> near_vertex_triangle, near_edge_edge;
  double drift = 0;  // m, upper bound of the change of any distance since the list was built

  bool is_self() const { return body_a == body_b; }
};

// Returns an empty list for every pair of bodies that the contact search covers, at any distance.
// O(bodies^2).
std::vector<CandidateList> searched_pairs(const Scene& scene);
// Returns an empty list for every pair of bodies that the contact search covers and whose widened
// boxes meet at t = 0. A box is widened by half the sum of the body's thickness, the range and the
// slack.
std::vector<CandidateList> neighbours_at_start(const Scene& scene);
// Returns the distance (m) by which candidate lists reach beyond thickness + range.
double search_slack(const Scene& scene);
// Returns the geodesic distance at rest (m) below which features of a body are not in contact with
// each other. It is 0 for meshes whose vertices are all farther than thickness + range from the
// triangles that they do not belong to: contact then holds nearest neighbours apart too. For finer
// meshes it is pi/2 thickness + range. This is half the circumference of a circle of the diameter
// `thickness`, and `range` more: across a round fold, features beyond that distance are no closer
// than the layers of the fold, or keep a gap of more than half the range. O(triangles within
// thickness + range of all vertices).
double neighbour_radius(const SceneBody& body, double range);

// Keeps candidate lists of pairs of bodies. With the exceptions below, the lists contain every pair
// of features closer than thickness + range at the positions or along the paths of the last update.
// They are built with a slack and remain valid until the bodies have moved by that distance. A
// translation of a whole body does not count for pairs within the body. A common translation of two
// bodies does not count for pairs between them.
//
// Neighbours at rest have lists of their own. A triangle is a neighbour of a vertex if it belongs
// to the vertex's neighbourhood of neighbour_radius() (bsi/detail/neighbourhoods.h). Their lists
// contain every pair of neighbours that meets at the positions or along the paths.
//
// Every body has a box. The box of a moving body is larger than necessary. Pairs of bodies whose
// boxes do not meet have no list and cost nothing. A body that leaves its box gets a new box, and a
// tree finds its new neighbours. If the bounding spheres of two neighbours are farther apart than
// their list reaches, the list stays empty until the bodies might have met.
//
// Obstacles that move as rigid bodies may be given by their poses, from which their positions and
// displacements are bounded. Their vertices are placed only where positions are needed.
//
// The lists leave out pairs of features with a common vertex. They also leave out pairs whose
// points all follow prescribed paths, because no force could separate these features.
class ContactSearch {
 public:
  ContactSearch(const Scene& scene, Statistics& statistics, ChosenSearch search);

  // Makes the lists complete at the positions `now` of all surface points, m. If a point of a
  // moving body is not finite or is extremely far away (1e15 m), returns its index.
  [[nodiscard]] std::optional<int> update(const PlacedPoints& now);
  [[nodiscard]] std::optional<int> update(std::span<const Vec3> position) {
    return update(PlacedPoints(position));
  }
  // Makes the lists complete along the straight paths start -> end of all surface points, m, and
  // along all paths that deviate from these by at most `stray` (m, by body; empty: zero). Returns
  // the same as update().
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
  // Returns the neighbourhoods at rest of a body's surface points, or null if its features are
  // neighbours only where they have a common vertex.
  const bsi::Neighbourhoods* neighbourhoods(int body) const {
    return tracked_[body].neighbourhoods.get();
  }
  double slack() const { return slack_; }
  // Returns the processor that runs the search. If a device fails, the CPU takes over with the same
  // results.
  const ComputeChoice& compute() const { return search_.choice; }

 private:
  // The displacement of a body since a snapshot, m. All its points satisfy |x - x_snapshot - mean|
  // <= residual.
  struct Displacement {
    Vec3 mean{0, 0, 0};
    double residual = 0;
    double largest() const { return mean.norm() + residual; }
  };
  using Box = BodyTree::Box;
  struct Tracked {
    // Positions of the body's points when its lists were last built, m. For lists of paths, these
    // are the ends of the paths. Empty if the body does not move or has not had a list yet, or if
    // `pose` replaces it.
    std::vector<Vec3> snapshot;
    std::vector<Vec3> path_start;  // m, starts of the paths; empty without paths
    // For a rigid obstacle given by its pose, the poses that replace `snapshot` and `path_start`.
    std::optional<RigidPose> pose, path_start_pose;
    double path_length = 0;  // m, sum of the displacements between all earlier snapshots
    Displacement now;        // displacement since the snapshot at the end of the present path
    // Displacement since the snapshot at the start of the path. Without a path, equal to `now`.
    Displacement at_start;
    double largest() const { return std::max(now.largest(), at_start.largest()); }
    Box box;           // box around the body's present points or paths, without stray
    double stray = 0;  // m, bound of the deviation of its points from the present path
    bool pyramid_built = false;
    // Sphere around the body at its snapshot, or around its path. The radius is negative until the
    // first snapshot.
    bsi::Sphere bounds;
    // Neighbourhoods at rest of the body's points; null if they are rings or the body is not
    // searched for contact with itself.
    std::unique_ptr<const bsi::Neighbourhoods> neighbourhoods;
  };
  struct ListState {
    // True if the list is built from pyramids, false if bounding spheres exclude all its pairs.
    bool near = false;
    bool built = false;
    // Distance (m) that both bodies together may move until the pair is no longer excluded.
    double clearance = 0;
    // Sum of both bodies' path_length (m) when the pair was excluded.
    double path_length = 0;
    // Sum of the strays (m) of both bodies for which the list was built.
    double stray = 0;
  };

  void find_neighbourhoods(int body);
  std::span<const Vec3> of_body(std::span<const Vec3> all, int body) const;
  // Finds the displacements of all moving bodies since their snapshots or, with `from_start`, since
  // their path_start. Extends the boxes of the bodies by the positions `now`. Returns the same as
  // update().
  std::optional<int> track(const PlacedPoints& now, bool from_start = false);
  bool track_pose(const RigidObstacle& obstacle, const PlacedPoints& now, bool from_start);
  bool track_points(int body, std::span<const Vec3> now, bool from_start);
  void fill_snapshot(const RigidObstacle& obstacle);
  static Displacement displacement(std::span<const Vec3> snapshot, std::span<const Vec3> now);
  static Displacement displacement(const RigidObstacle& obstacle, const RigidPose& snapshot,
                                   const RigidPose& now);
  std::optional<int> find_lost(std::span<const Vec3> position, int body) const;
  // Gives new boxes to bodies that have left their boxes, and updates the set of lists.
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
  std::vector<int> moving_;   // indices of the bodies that move
  BodyTree tree_;             // tree of the results of enlarged_box()
  std::vector<char> placed_;  // by body: nonzero if this update gives it a new box
  std::vector<CandidateList> lists_;
  std::vector<ListState> states_;  // by list
  ChosenSearch search_;
  std::vector<std::size_t> building_;                   // indices of the lists being built
  std::vector<PairQuery> queries_;                      // by entry of building_
  std::vector<std::vector<bsi::LeafPair>> quad_pairs_;  // by entry of building_
};

}  // namespace weft::sim
