// Contact between surface points: the pairs in reach, with barriers, damping and friction per area
// that are smooth functions of the state, and the check of paths.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bsi/detail/feature_batches.h"
#include "bsi/detail/surface_terms.h"
#include "bsi/proximity.h"
#include "sim/base/statistics.h"
#include "sim/contact/contact_pair.h"
#include "sim/contact/contact_search.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Why a state or a step cannot be taken.
struct ContactFault {
  enum class Kind { not_finite, touching, crossing, in_reach, overstretched };
  Kind kind = Kind::touching;
  // The surface points of the pair. A fault of kind not_finite has only one entry: a point if the
  // fault comes from SurfaceContact, a particle if it comes from Contact or its callers. A fault of
  // kind overstretched, which only Dynamics finds, has a particle.
  std::array<int, 4> nodes{-1, -1, -1, -1};
  double gap = 0;  // m
  std::string describe(const Scene& scene) const;
  // The particle where it happened: the one with the largest weight in the first point.
  int particle(const Scene& scene) const;
};

// Upper bounds (m) of the distances of surface points from their straight paths: by body, of all
// its points, and by dynamic point. Both are empty if all paths are straight.
struct PointStray {
  std::span<const double> body, point;
};

// Forces that the mollifier of near-parallel edges adds to the forces on the four points.
struct MollifierForce {
  std::array<int, 4> nodes{};
  std::array<Vec3, 4> force;
};

// Each vertex of a dynamic surface is a sample of the area around it. It meets another surface, or
// its own beyond the triangles around it, by the signed sum over that surface's features in range
// (bsi/detail/surface_terms.h). The sum counts the surface once, so the force per area does not
// depend on the meshes. If both surfaces are dynamic, the samples of each count half.
//
// Samples do not detect two edges that cross, nor an obstacle's vertex that points into a triangle.
// Pairs of these two kinds have a barrier of their own over the last quarter of the range, with as
// much energy over this shorter way.
//
// A pair (or term) at distance d, with gap g = d - thickness below its range, pushes along its
// normal with barrier and damping together (materials/contact.h) and rubs across it (Sliding,
// contact_pair.h).
class SurfaceContact {
 public:
  SurfaceContact(const Scene& scene, Statistics& statistics, ChosenSearch search);

  // Finds the pairs in reach and their forces. `velocity` is of all surface points (m/s).
  [[nodiscard]] std::optional<ContactFault> evaluate(const PlacedPoints& now,
                                                     std::span<const Vec3> velocity, int threads);
  // Results of the last evaluate(); empty after a fault. ContactPair::sliding is the argument of
  // sliding().
  std::span<const ContactPair> pairs() const { return pairs_; }
  const Sliding& sliding(int number) const { return sliding_[number]; }
  bool has_sliding() const { return !sliding_.empty(); }
  std::span<const MollifierForce> mollified() const { return mollified_; }
  // Marks, by body, the sleeping bodies that came within range of a dynamic body in any evaluation
  // since the last forget_touched().
  std::span<const char> touched() const { return touched_; }
  void forget_touched() { touched_.assign(touched_.size(), 0); }
  // Sets the Coulomb coefficient from now on.
  void set_friction(double friction) { friction_ = friction; }
  // From now on, sets negative stiffness and damping of pairs, and the friction slope of subtracted
  // terms, to zero: for long fixed steps.
  void keep_matrix_definite() { definite_ = true; }
  const RigidObstacles& obstacles() const { return search_.obstacles(); }
  // The device that the search runs on.
  const ComputeChoice& compute() const { return search_.compute(); }

  // Returns a fault unless every pair of features is certain to keep apart and to end with a
  // positive gap: on the straight paths start -> end, and on all paths no farther from these than
  // `stray`.
  [[nodiscard]] std::optional<ContactFault> check_path(const PlacedPoints& start,
                                                       const PlacedPoints& end,
                                                       const PointStray& stray);
  // Checks part of the straight path of a step that has been found free: up to a point on it. No
  // gap is required there or on the way; surfaces need only not meet.
  [[nodiscard]] std::optional<ContactFault> check_crossing(const PlacedPoints& start,
                                                           const PlacedPoints& end);
  // Finds the smallest gap (m) within the range at `position`; infinite if there is none. Returns a
  // fault if a gap is not positive.
  [[nodiscard]] std::optional<ContactFault> check_state(std::span<const Vec3> position,
                                                        double* smallest_gap);
  // Returns a pair of features of one body closer than thickness + range at `position`, if any.
  [[nodiscard]] std::optional<ContactFault> self_pair_in_reach(std::span<const Vec3> position);

 private:
  struct Pair {
    std::array<int, 4> nodes{};
    bool edges = false;
    double thickness = 0;
  };
  // Candidates of one list and kind.
  struct PairGroup {
    bool edges = false;
    bool samples = false;  // vertices that meet a surface; the others have the short barrier
    double thickness = 0;
    int body_a = 0, body_b = 0;
    int surface = 0;  // of samples: the body of the triangles
    bool is_self() const { return body_a == body_b; }
    std::vector<bsi::FourParticles> nodes;
    std::vector<int> triangles;  // of samples: local to that body
    bsi::FeatureKind kind() const {
      return edges ? bsi::FeatureKind::edge_edge : bsi::FeatureKind::vertex_triangle;
    }
    Pair pair(std::size_t i) const { return {nodes[i], edges, thickness}; }
  };
  // The results of one chunk of the candidates.
  struct Found {
    std::vector<ContactPair> pairs;
    std::vector<Sliding> sliding;
    std::vector<MollifierForce> mollified;
    std::optional<ContactFault> fault;
  };

  template <class Visit>
  void visit_candidates(double reach, const Visit& visit) const;
  double pair_area(const std::array<int, 4>& nodes, int split) const;
  double range_of(const PairGroup& group) const;
  bool is_dynamic(int point) const { return point < scene_.dynamic_points; }
  void find_spins(const PlacedPoints& now, std::span<const Vec3> velocity);
  void begin_placing();
  void place_nodes(const PairGroup& group, const PlacedPoints& start, const PlacedPoints& end);
  std::optional<Vec3> obstacle_spin(const std::array<int, 4>& nodes) const;
  std::vector<PairGroup> groups_within(double sample_reach, double reach) const;
  void note_touch(const PairGroup& group, std::span<const Vec3> position);
  void measure_part(const PairGroup& group, std::size_t first, std::size_t last,
                    std::span<const Vec3> position, std::span<const Vec3> velocity,
                    Found& found) const;
  // Lists of the sample in hand. The next sample reuses their memory.
  struct SampleScratch {
    std::vector<int> triangles;
    std::vector<bsi::SurfaceTerm> terms;
  };
  void measure_sample(const PairGroup& group, std::size_t first,
                      std::span<const bsi::PairInReach> in_reach, std::span<const Vec3> position,
                      std::span<const Vec3> velocity, SampleScratch& scratch, Found& found) const;
  void measure_pair(const Pair& pair, std::span<const Vec3> position,
                    std::span<const Vec3> velocity, Found& found) const;
  void add_pair(const ContactLaw& law, const Pair& features, const bsi::Closest& closest,
                double mollifier, double coefficient, std::span<const Vec3> position,
                std::span<const Vec3> velocity, Found& found) const;
  double mollify(const Pair& pair, const bsi::Closest& closest, std::span<const Vec3> position,
                 const ContactLaw& law, Found& found) const;
  void join(Found& part);
  void clear();
  double stray_of(const Pair& pair, const PointStray& stray) const;
  // The conditions that a path must meet.
  struct PathDemand {
    bool gap = true;  // require half the thickness on the way and all of it at the end
    PointStray stray;
  };
  std::optional<ContactFault> find_path_fault(const PlacedPoints& start, const PlacedPoints& end,
                                              const PathDemand& demand);
  std::optional<ContactFault> check_part(const PairGroup& group, std::size_t first,
                                         std::size_t last, std::span<const Vec3> start,
                                         std::span<const Vec3> end, const PathDemand& demand) const;

  const Scene& scene_;
  Statistics& statistics_;
  ContactSearch search_;
  double range_, stiffness_, damping_time_, friction_, friction_speed_;
  bool definite_ = false;
  std::vector<Vec3> rest_;                   // of all points: edge lengths scale the mollifier
  std::vector<bsi::SurfaceTerms> surfaces_;  // by body
  std::vector<int> moving_obstacles_;        // bodies
  PlacedMarks marks_;
  std::vector<Vec3> spins_;  // rad/s, by body; zero except for moving obstacles
  std::vector<char> touched_;
  std::vector<ContactPair> pairs_;
  std::vector<Sliding> sliding_;
  std::vector<MollifierForce> mollified_;
};

}  // namespace weft::sim
