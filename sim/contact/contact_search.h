// Finds pairs of features that may touch. Lists of candidates are reused until bodies may have
// moved so far that the lists are incomplete.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bsi/detail/fold_watch.h"
#include "bsi/detail/neighbourhoods.h"
#include "bsi/pyramid.h"
#include "sim/base/statistics.h"
#include "sim/contact/body_motion.h"
#include "sim/contact/body_tree.h"
#include "sim/contact/compute_choice.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The barrier of pairs without a sample has a range of its own, as a fraction of the contact range.
// These are two edges, and a vertex of an obstacle with a triangle.
inline constexpr double short_range = 0.25;

// A vertex and a triangle, or two edges, by their indices in the meshes of their bodies.
struct FeaturePair {
  int a = 0;
  int b = 0;
  float distance = 0;  // m, lower bound of the distance at an earlier time
};

// Two bodies, a < b, or one body with itself, a == b.
struct BodyPair {
  int a = 0;
  int b = 0;
  // clang-tidy 14 mistakes the generated comparison with 0 for one with a null pointer.
  auto operator<=>(const BodyPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

// Pairs of features of two bodies, or of one body with itself.
struct FeaturePairs {
  std::vector<FeaturePair> vertex_triangle;  // vertex of body_a, triangle of body_b
  std::vector<FeaturePair> triangle_vertex;  // vertex of body_b, triangle of body_a; empty for self
  std::vector<FeaturePair> edge_edge;        // edges of body_a and body_b; for self a < b
  // Pairs of neighbours at rest, within one body or across a seam. They are not in contact at any
  // distance, but must not pass through each other. The second list is empty for self.
  std::vector<FeaturePair> near_vertex_triangle, near_triangle_vertex, near_edge_edge;
  static constexpr int list_count = 6;

  // Calls use(list of pairs, the same list of `other`, has edges, are neighbours) for all lists.
  template <class Other, class Use>
  void for_each_with(Other& other, const Use& use) {
    use(vertex_triangle, other.vertex_triangle, false, false);
    use(triangle_vertex, other.triangle_vertex, false, false);
    use(edge_edge, other.edge_edge, true, false);
    use(near_vertex_triangle, other.near_vertex_triangle, false, true);
    use(near_triangle_vertex, other.near_triangle_vertex, false, true);
    use(near_edge_edge, other.near_edge_edge, true, true);
  }
  bool is_empty() const {
    return vertex_triangle.empty() && triangle_vertex.empty() && edge_edge.empty() &&
           near_vertex_triangle.empty() && near_triangle_vertex.empty() && near_edge_edge.empty();
  }
};

// The candidates of two bodies, or of one body with itself. Each list of pairs is sorted by (a, b),
// so that the order does not depend on the processor that found them.
struct CandidateList : FeaturePairs {
  int body_a = 0;
  int body_b = 0;
  double thickness = 0;  // mean thickness of both bodies, m
  double drift = 0;      // m: no distance is below that of FeaturePair by more
  // Changes whenever the pairs change, to a number that no other list has or had. 0 while the list
  // has had no pairs yet.
  std::int64_t version = 0;
  // Neighbourhoods at rest, across seams, of the vertices of body_a in body_b and of those of
  // body_b in body_a. Null for self, and where no seam joins the bodies or their meshes need none.
  const bsi::Neighbourhoods* first_across = nullptr;
  const bsi::Neighbourhoods* second_across = nullptr;

  bool is_self() const { return body_a == body_b; }
  // Returns the number of candidates. Neighbours at rest are none.
  std::size_t candidate_count() const {
    return vertex_triangle.size() + triangle_vertex.size() + edge_edge.size();
  }
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
// For pairs without a sample, the range is `short_range` of the contact range, unless a body
// sleeps.
//
// Candidates are selected from larger lists. These contain the pairs that are near in a snapshot of
// the positions, by a slack. When points have moved by that slack, the points that have moved most
// are recorded anew, and only pairs with such a point are looked for again. The distance of a pair
// in the snapshot, less the displacements of both features since, tells without the positions that
// it is out of reach. Candidates stay selected until points have moved by a small part of the
// slack.
//
// A snapshot looks ahead where velocities are known: it contains the paths on which points will go
// on, and points count as moved only as far as they leave these. Lists then last for several steps
// of points that move by the slack in each.
//
// The pairs within a body come from a snapshot of its own, relative to the mean of its points. A
// translation of a whole body therefore does not count for them. A common translation of two bodies
// does not count for pairs between them.
//
// Neighbours at rest have lists of their own. A triangle is a neighbour of a vertex if it belongs
// to the vertex's neighbourhood of neighbour_radius() (bsi/detail/neighbourhoods.h), which goes on
// across seams (seam_neighbours.h). Their lists contain every pair of neighbours that meets at the
// positions or along the paths.
//
// Every body has a box in a tree. The box of a moving body is larger than necessary. Pairs of
// bodies whose boxes do not meet have no list and cost nothing. A body that leaves its box gets a
// new box, and the tree finds its new neighbours. The list of two neighbours stays empty until the
// boxes around their present positions come within reach.
//
// Obstacles that move as rigid bodies may be given by their poses, from which their positions and
// displacements are bounded. Their vertices are placed only where positions are needed.
//
// Adjacent quads of one body are watched instead of listed while none of their features is within
// reach of another (bsi/detail/fold_watch.h).
//
// The lists leave out pairs of features with a common vertex. They also leave out pairs whose
// points all follow prescribed paths, because no force could separate these features.
class ContactSearch {
 public:
  ContactSearch(const Scene& scene, Statistics& statistics, ChosenSearch search);

  // Makes the lists complete at the positions `now` of all surface points, m. `velocity` (m/s, by
  // point; empty if unknown) and the times tell where points are likely to go; they change the cost
  // alone. If a point of a moving body is not finite or is extremely far away (1e15 m), returns its
  // index.
  [[nodiscard]] std::optional<int> update(const PlacedPoints& now,
                                          std::span<const Vec3> velocity = {});
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
  const RigidObstacles& obstacles() const { return motion_.obstacles(); }
  // Returns the neighbourhoods at rest of a body's surface points, or null if its features are
  // neighbours only where they have a common vertex.
  const bsi::Neighbourhoods* neighbourhoods(int body) const { return neighbourhoods_[body].get(); }
  // Returns the processor that runs the search. If a device fails, the CPU takes over with the same
  // results.
  const ComputeChoice& compute() const { return search_.choice; }
  // Returns the distance (m) by which the motions of two features, with the strays of their paths,
  // may grow together until candidates are selected anew.
  double candidate_slack() const { return candidate_slack_; }
  // Returns a number that changes whenever lists(), but for their drift, may have changed.
  std::int64_t changes() const { return changes_; }
  // Adds to the reason of compute() that the narrow phase of the device has failed.
  void note_failure(const std::string& reason) {
    search_.choice.reason += "; its narrow phase failed: " + reason;
  }
  std::unique_ptr<DeviceContact> make_device_contact() const;

 private:
  using Box = BodyTree::Box;
  struct ListState {
    bool near = false;   // false if the list is empty because the boxes of the bodies are far apart
    bool whole = false;  // true if all its pairs must be looked for
    double stray = 0;    // m, sum of the strays of both bodies for which `pairs` is complete
    double selected_stray = 0;  // m, the same for the candidates
    FeaturePairs pairs;         // the pairs that are near in the snapshot
  };
  struct Selected {
    std::vector<FeaturePair> room;
    std::span<const FeaturePair> pairs;  // in `room`
  };
  // The records that an update makes anew for one body.
  struct Renewal {
    // Points that have moved farther (m) are recorded anew; infinite if none are.
    double placed_limit = std::numeric_limits<double>::infinity(), own_limit = placed_limit;
    bool has_pairs = false, has_moving_pairs = false, has_own_pairs = false;  // of near lists
  };

  void find_neighbourhoods(int body);
  void find_neighbours_across_seams();
  void set_across(CandidateList& list) const;
  std::optional<int> follow(const PointPaths& paths, std::span<const double> stray,
                            std::span<const Vec3> velocity);
  void find_neighbours();
  void place_all();
  Box needed_box(int body) const;
  Box enlarged_box(int body) const;
  void replace_lists(std::span<const int> placed);
  void merge_lists(std::span<const BodyPair> pairs);
  double stray(const CandidateList& list) const {
    return motion_.stray(list.body_a) + motion_.stray(list.body_b);
  }
  double drift(const CandidateList& list) const;
  bool are_apart(const CandidateList& list, double distance) const;
  void refresh();
  void find_near_lists();
  void measure();
  bool find_expired();
  bool find_folds(const CandidateList& list);
  bool find_torn();
  void ask_for_renewal(std::size_t list);
  void renew();
  void clear(std::size_t list);
  double growth_since_choice(const CandidateList& list) const;
  bool is_outdated(std::size_t list) const;
  void select_candidates();
  void select_of_two_bodies();
  void select(std::size_t list);
  void rebuild_pyramids();
  void find_quad_pairs();
  void place_found();
  void build_lists();
  // Returns the range (m) of pairs of two edges, or of the vertices of one body of a list.
  double range_of_edges(const CandidateList& list) const {
    return scene_.bodies[list.body_b].sleeps ? range_ : short_range * range_;
  }
  double range_of_vertices(const CandidateList& list, int body) const;
  // list_slack() and reach() return the distances (m) in the snapshot up to which a list contains
  // neighbours at rest and other pairs.
  double list_slack(std::size_t list) const { return slack_ + states_[list].stray; }
  double reach(std::size_t list) const {
    return lists_[list].thickness + range_ + list_slack(list);
  }

  const Scene& scene_;
  Statistics& statistics_;
  double range_ = 0;
  double slack_ = 0;
  double candidate_slack_ = 0;  // m, by which points may move until candidates are selected anew
  BodyMotion motion_;
  // By body: neighbourhoods at rest of its points; null if they are rings or the body is not
  // searched for contact with itself.
  std::vector<std::unique_ptr<const bsi::Neighbourhoods>> neighbourhoods_;
  // Neighbourhoods at rest across seams: of the vertices of body a in the surface of body b.
  std::map<BodyPair, std::unique_ptr<const bsi::Neighbourhoods>> across_seams_;
  // By body: says which adjacent quads are out of reach of each other. Lists leave out their pairs.
  // Null if the body is not searched for contact with itself.
  std::vector<std::unique_ptr<bsi::FoldWatch>> folds_;
  std::vector<char> folded_;  // by point: nonzero if it belongs to quads that are so no longer
  BodyTree tree_;             // tree of the results of enlarged_box()
  std::vector<char> placed_;  // by body: nonzero if this update gives it a new box
  std::vector<CandidateList> lists_;
  std::int64_t changes_ = 0;
  std::vector<ListState> states_;   // by list
  std::vector<Selected> selected_;  // by chunk of the last selection
  std::vector<Renewal> renewals_;   // by body
  std::vector<int> near_bodies_;    // indices of the bodies of near lists
  // By body: nonzero if the pyramid of its record among placed or own positions is up to date.
  std::vector<char> placed_pyramid_, own_pyramid_;
  ChosenSearch search_;
  std::vector<std::size_t> building_;                   // indices of the lists being built
  std::vector<PairQuery> queries_;                      // by entry of building_
  std::vector<std::vector<bsi::LeafPair>> quad_pairs_;  // by entry of building_
};

}  // namespace weft::sim
