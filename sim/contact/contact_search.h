// Which features may touch: candidate lists from the pyramids, kept while nothing can have moved
// into reach.
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

// A vertex and a triangle, or two edges, by their numbers in the meshes of their bodies.
struct FeaturePair {
  int a = 0;
  int b = 0;
  float distance = 0;  // a lower bound, m, where the list was built
};

// Two bodies, a <= b; one with itself where they are equal.
struct BodyPair {
  int a = 0;
  int b = 0;
  // clang-tidy 14 takes the compiler's own comparison with 0 for one with a null pointer.
  auto operator<=>(const BodyPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

// The candidates of two bodies (or of one with itself). Each list is sorted by (a, b), so that the
// pairs in reach come in the same order however the list was found.
struct CandidateList {
  int body_a = 0;
  int body_b = 0;
  double thickness = 0;                      // mean of the two, m
  std::vector<FeaturePair> vertex_triangle;  // vertex of a, triangle of b
  std::vector<FeaturePair> triangle_vertex;  // vertex of b, triangle of a; empty for self
  std::vector<FeaturePair> edge_edge;        // edge of a, edge of b; for self a < b
  double drift = 0;  // how far any distance can have changed since the list was built, m

  bool is_self() const { return body_a == body_b; }
};

// One empty list for every pair of bodies that may touch, near or far: O(bodies^2).
std::vector<CandidateList> searched_pairs(const Scene& scene);
// One empty list for every pair whose bodies are close enough at the start that contact looks at
// them.
std::vector<CandidateList> neighbours_at_start(const Scene& scene);
// How far beyond thickness + range the lists reach, m.
double search_slack(const Scene& scene);

// Keeps, for every pair of bodies that may touch, all feature pairs closer than
// thickness + range at the positions last given to update(). Lists are built with a slack and
// remain valid until the bodies have moved by it, translations of a whole body (for self pairs) and
// common translations (for two) taken out.
//
// Every body has a box with room to move in. Pairs whose boxes do not meet have no list and are not
// walked; a body that leaves its box gets a new one and, from a tree, new neighbours. Two
// neighbours whose bounding spheres lie further apart than the slack reach have an empty list until
// they could have met.
//
// Obstacles that move as rigid bodies may be given by their poses. How far they have moved, and
// where they are, is then bounded from these; their vertices are put in place only where lists are
// built from them.
//
// Pairs all of whose vertices follow prescribed paths are left out: no force could part them.
class ContactSearch {
 public:
  ContactSearch(const Scene& scene, Statistics& statistics, ChosenSearch search);

  // Makes the lists complete at `position` (all particles). Returns a particle that is not finite,
  // if any.
  [[nodiscard]] std::optional<int> update(const PlacedParticles& now);
  [[nodiscard]] std::optional<int> update(std::span<const Vec3> position) {
    return update(PlacedParticles(position));
  }
  // Makes them complete for every point of the straight paths start -> end, and of all paths whose
  // points are never further from these than `stray` (m, by body; empty: zero).
  [[nodiscard]] std::optional<int> update_path(const PlacedParticles& start,
                                               const PlacedParticles& end,
                                               std::span<const double> stray = {});
  [[nodiscard]] std::optional<int> update_path(std::span<const Vec3> start,
                                               std::span<const Vec3> end,
                                               std::span<const double> stray = {}) {
    return update_path(PlacedParticles(start), PlacedParticles(end), stray);
  }

  // The lists of neighbours, sorted by (body_a, body_b).
  std::span<const CandidateList> lists() const { return lists_; }
  const RigidObstacles& obstacles() const { return obstacles_; }
  double slack() const { return slack_; }
  // The device that the search runs on. It changes once at the most: a device that fails hands over
  // to the CPU, whose answers are the same.
  const ComputeChoice& compute() const { return search_.choice; }

 private:
  // How far a body has moved since a snapshot: |x - x_snapshot - mean| <= residual.
  struct Displacement {
    Vec3 mean{0, 0, 0};
    double residual = 0;
    double largest() const { return mean.norm() + residual; }
  };
  using Box = BodyTree::Box;
  struct Tracked {
    // Positions at which the lists were built, or the end of the path for which they were; empty
    // for a body that does not move or has never had a list.
    std::vector<Vec3> snapshot;
    std::vector<Vec3> path_start;  // the start of that path; empty where it was a point
    // A rigid obstacle that was given by its pose has poses here in place of both.
    std::optional<RigidPose> pose, path_start_pose;
    double path_length = 0;  // displacements summed over the snapshots left behind, m
    Displacement now;        // at the end of the path that is asked about
    Displacement at_start;   // at its start; without a path, the same
    double largest() const { return std::max(now.largest(), at_start.largest()); }
    Box box;           // around its points now, or their paths, without the stray
    double stray = 0;  // how far its points may be from the path that is asked about, m
    bool pyramid_built = false;
    bsi::Sphere
        bounds;  // of the body at its snapshot (of its path, after update_path); unset: radius < 0
  };
  struct ListState {
    bool near = false;  // built from the pyramids; otherwise ruled out by the bounding spheres
    bool built = false;
    double clearance =
        0;  // of a ruled-out pair: how far both may go before it must be looked at again, m
    double path_length = 0;  // of both bodies when it was ruled out
    double stray = 0;        // by which the list reaches further, m
  };

  std::span<const Vec3> of_body(std::span<const Vec3> all, int body) const;
  // Finds where all moving bodies are now, seen from the ends, or from the starts, of the paths of
  // the lists. Extends their boxes.
  std::optional<int> track(const PlacedParticles& now, bool from_start = false);
  bool track_pose(const RigidObstacle& obstacle, const PlacedParticles& now, bool from_start);
  bool track_points(int body, std::span<const Vec3> now, bool from_start);
  void fill_snapshot(const RigidObstacle& obstacle);
  static Displacement displacement(std::span<const Vec3> snapshot, std::span<const Vec3> now);
  static Displacement displacement(const RigidObstacle& obstacle, const RigidPose& snapshot,
                                   const RigidPose& now);
  std::optional<int> find_lost(std::span<const Vec3> position, int body) const;
  // Gives bodies that have left their boxes new ones, and brings the lists up to date with them.
  void find_neighbours(std::span<const Vec3> position);
  void place_all(std::span<const Vec3> position);
  Box needed_box(int body) const;
  Box roomy_box(int body) const;
  void replace_lists(std::span<const int> placed);
  void merge_lists(std::span<const BodyPair> pairs);
  ListState first_state(const CandidateList& list);
  double stray(const CandidateList& list) const;
  double drift(const CandidateList& list) const;
  static double drift(const CandidateList& list, const Displacement& a, const Displacement& b);
  bool is_valid(std::size_t list) const;
  bool are_valid() const;
  std::vector<char> bodies_to_refresh() const;
  void refresh(const PlacedParticles& start, const PlacedParticles& end);
  void renew_lists(const PlacedParticles& start, const PlacedParticles& end);
  void refresh_body(int body, const PlacedParticles& start, const PlacedParticles& end);
  bool rule_out(std::size_t list);
  BodyPath path_of(int body, const PlacedParticles& start, const PlacedParticles& end) const;
  void rebuild_pyramids(const PlacedParticles& start, const PlacedParticles& end);
  void find_quad_pairs(const PlacedParticles& start, const PlacedParticles& end);
  void place_found(const PlacedParticles& start, const PlacedParticles& end);
  void build_lists(const PlacedParticles& start, const PlacedParticles& end);
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
  BodyTree tree_;             // of boxes with room to move in and half of the reach
  std::vector<char> placed_;  // by body: has a new box in this update
  std::vector<CandidateList> lists_;
  std::vector<ListState> states_;  // of the lists
  ChosenSearch search_;
  // Work on the lists being built.
  std::vector<std::size_t> building_;
  std::vector<PairQuery> queries_;
  std::vector<std::vector<bsi::LeafPair>> quad_pairs_;
};

}  // namespace weft::sim
