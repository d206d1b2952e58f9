// Contact forces between surfaces, and checks whether paths of the surfaces meet. Barriers, damping
// and friction are smooth functions of the state.
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
#include "sim/contact/anchors.h"
#include "sim/contact/contact_pair.h"
#include "sim/contact/contact_search.h"
#include "sim/contact/device_contact.h"
#include "sim/contact/pair_friction.h"
#include "sim/contact/sphere_contact_laws.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The reason why a state or a step is rejected, or why a run ends. `pressed` surfaces have a gap,
// but almost none.
struct ContactFault {
  enum class Kind { not_finite, touching, pressed, crossing, curved, overstretched };
  Kind kind = Kind::touching;
  // The surface points of the pair. In a fault of kind not_finite, only the first entry is used. It
  // is a point in results of SurfaceContact, and a particle in results of Contact. In a fault of
  // kind overstretched, which only Dynamics finds, the first entry is a particle.
  std::array<int, 4> nodes{-1, -1, -1, -1};
  // m. In a fault of kind curved, the distance by which both curved surfaces may leave the
  // triangles of the pair.
  double gap = 0;
  std::string describe(const Scene& scene) const;
  // Returns a particle at which the fault occurred. It is the particle with the largest weight in
  // the first point. For the kind not_finite, it is nodes[0].
  int particle(const Scene& scene) const;
};

// Upper bounds (m) of the distances of surface points from their straight paths. `body` has one
// bound for all points of each body, `point` one per dynamic point. Both lists are empty if all
// paths are straight.
struct PointStray {
  std::span<const double> body, point;
};

// Upper bounds (m) of the distances between curved surfaces and their triangles along a path, as
// far as the thickness does not cover them: `body` and `point` as those of PointStray. `covered` is
// the covered part as a fraction of a body's thickness. The lists are empty if nothing is left.
struct CurveStray : PointStray {
  double covered = 0;
};

// A pair of features that keep apart on a path, though perhaps not by as much as curved surfaces
// may leave them. Points 0 .. split - 1 belong to the first feature.
struct OpenPair {
  std::array<int, 4> nodes{};
  int split = 1;
  double left_by = 0;  // m, by which both curved surfaces may leave the triangles of the pair
};

// Two features that would meet on a path.
struct Meeting {
  ContactPair pair;     // nodes, weights and normal where they meet; without forces
  double fraction = 1;  // of the path, at which they come too near; 1 if they do so at its end
  double gap = 0;       // m, shortly before they meet, or at the end
  double room = 0;      // m, by which the features may approach each other along the normal
};

// Contact of samples with surfaces. Each vertex of a dynamic surface is a sample of the area around
// it. Its force comes from a signed sum over the features in range on one other surface, or on its
// own surface beyond the triangles around it (bsi/detail/surface_terms.h). The sum counts a surface
// once, so the force per area does not depend on the meshes. If both surfaces are dynamic, the
// samples of each count half. Features of one body that are neighbours at rest are not in contact
// (ContactSearch); only check_path(), check_crossing() and check_state() keep them apart, at any
// distance above 0.
//
// Samples detect neither two edges that cross nor an obstacle's vertex that points into a triangle.
// These pairs have a barrier of their own over the last quarter of the range. It is stiffer, so
// that a fraction of its range stores as much energy as the same fraction of the whole range.
//
// The centre of a sphere ([[particles]]) is a sample, too, and its radius is half its thickness.
// Spheres touch each other in pairs of two points. On cloth, the barrier of the centre is short,
// and the vertices of the cloth are samples against the sphere, so that a sheet that wraps a ball
// presses on it everywhere. Friction acts on the difference of the velocities of a sphere's surface
// and of the point that it touches.
//
// A pair or term at distance d has the gap g = d - thickness. If g is below the range, barrier and
// damping push along the normal (materials/contact.h), and friction acts across the normal
// (Sliding, contact_pair.h).
class SurfaceContact {
 public:
  SurfaceContact(const Scene& scene, Statistics& statistics, ChosenSearch search);

  // Finds the pairs in reach and their forces. `velocity` has the velocities of all surface points
  // (m/s). Returns a fault if a position is not finite or a gap is not positive.
  [[nodiscard]] std::optional<ContactFault> evaluate(const PlacedPoints& now,
                                                     std::span<const Vec3> velocity, int threads);
  // pairs(), sliding() and mollified() return results of the last evaluate(). There are no results
  // after a fault. The argument of sliding() is ContactPair::sliding.
  std::span<const ContactPair> pairs() const { return pairs_; }
  const Sliding& sliding(int number) const { return sliding_[number]; }
  // Gives access to the friction of a pair, to change it until the next evaluate().
  Sliding& sliding(int number) { return sliding_[number]; }
  double friction_speed() const { return friction_speed_; }
  bool has_sliding() const { return !sliding_.empty(); }
  std::span<const MollifierForce> mollified() const { return mollified_; }
  // Returns one mark per body. It is nonzero if the body sleeps and has come within range of a
  // dynamic body in an evaluation since the last forget_touched().
  std::span<const char> touched() const { return touched_; }
  void forget_touched() { touched_.assign(touched_.size(), 0); }
  // Sets the Coulomb coefficient, in later evaluations, of bodies for which no [[contact.pair]]
  // holds.
  void set_friction(double friction) {
    friction_.set_default(friction);
    spheres_.set_friction(friction);
  }
  // Makes the matrices of later evaluations positive semi-definite, for long fixed steps. Negative
  // stiffness and damping of pairs, and the friction slope of subtracted terms, are set to zero.
  void keep_matrix_definite() { definite_ = true; }
  // Announces that the next evaluate() is at the first iterate of a Newton iteration, and the ones
  // after it at the others. Where sliding has turned back since the last iterate, the slope of
  // friction (Sliding) is then that of the secant from rest: a correction with the derivative,
  // which is zero in full friction, has leapt past rest, and the next one would leap back. With a
  // given number of corrections and keep_matrix_definite(), all friction has the slope of its
  // secant at all iterates (docs/decisions/0096).
  //
  // At the first iterate of such a step, particles are at its start. `step` is its length (s), or
  // 0. If it is given, obstacles must be at its start, too, with their mean velocities in the step.
  // Barriers then push as their stiffness says for the places that obstacles will reach, and
  // anchors as for those that obstacles and free particles will reach with their velocities.
  void begin_newton(double step = 0) {
    iterate_ = 0;
    newton_step_ = step;
  }
  // Ends the look ahead of begin_newton(), also if the first evaluation has failed.
  void end_newton() { newton_step_ = 0; }
  // Returns the `step` of begin_newton() if the next evaluation is at the first iterate, else 0.
  double step_ahead() const { return iterate_ == 0 ? newton_step_ : 0; }
  // Holds samples, in later evaluations, to the anchors that the history selects, and lets go of
  // them by contact.sticking_distance. Without this call, contacts that stick creep.
  void use_anchors(const AnchorHistory& anchors) { anchors_ = &anchors; }
  bool has_anchors() const { return anchors_ != nullptr; }
  // Replaces the anchors by those at the end of a step: samples in contact keep theirs, drag it
  // along or get a new one (advanced_anchor()); others lose theirs. Samples of sleeping bodies keep
  // theirs. Precondition: the last evaluate() was at the end of the step, and its positions still
  // exist.
  void advance_anchors(Anchors& anchors) const;
  const RigidObstacles& obstacles() const { return search_.obstacles(); }
  // Returns the processor that runs the contact search.
  const ComputeChoice& compute() const { return search_.compute(); }

  // Returns a fault unless every pair of features that ContactSearch covers provably stays apart
  // and ends with a positive gap. The proof covers the straight paths start -> end and all paths
  // that deviate from them by at most `stray`. The pairs in open() keep apart likewise, but not by
  // `curve` more. Curved surfaces that leave their triangles by no more than `curve`, and what
  // thickness covers, therefore stay apart except around open pairs.
  [[nodiscard]] std::optional<ContactFault> check_path(const PlacedPoints& start,
                                                       const PlacedPoints& end,
                                                       const PointStray& stray,
                                                       const CurveStray& curve = {});
  // Checks the first part, start -> end, of the straight path of a step. Returns a fault if
  // surfaces may meet on it. Unlike check_path(), it does not require a gap.
  [[nodiscard]] std::optional<ContactFault> check_crossing(const PlacedPoints& start,
                                                           const PlacedPoints& end,
                                                           const CurveStray& curve = {});
  // Appends to `meetings` the pairs for which check_path() would return a fault, and the pairs that
  // would end with less than a fifth of their range. Weights and normal of a meeting are those
  // shortly before the features meet. Its room leaves half the range, or most of a smaller gap at
  // the start. Returns a fault only if a position is not finite. Costs as much as check_path(), and
  // about 1 us for each meeting.
  [[nodiscard]] std::optional<ContactFault> find_meetings(const PlacedPoints& start,
                                                          const PlacedPoints& end,
                                                          const PointStray& stray,
                                                          std::vector<Meeting>& meetings);
  // Adds a pair to pairs() until the next evaluate() or remove_added_pairs().
  void add_pair(const ContactPair& pair) {
    pairs_.push_back(pair);
    ++added_pairs_;
  }
  void remove_added_pairs() {
    pairs_.resize(pairs_.size() - added_pairs_);
    added_pairs_ = 0;
  }
  // Returns the open pairs of the last check_path() or check_crossing().
  std::span<const OpenPair> open() const { return open_; }
  // Sets *smallest_gap to the smallest gap (m) of the candidates at `position`, or to infinity if
  // there are no candidates. The candidates include all pairs within their range. Returns a fault
  // if a gap is not positive, if two neighbours touch, or if a position is not finite.
  [[nodiscard]] std::optional<ContactFault> check_state(std::span<const Vec3> position,
                                                        double* smallest_gap);

 private:
  struct Pair {
    std::array<int, 4> nodes{};
    bool edges = false;
    double thickness = 0;
  };
  struct Nodes {
    std::vector<bsi::FourParticles> nodes;
    std::vector<int> triangles;  // for samples: by pair, triangle in the mesh of its surface
    void append(const Nodes& more) {
      nodes.insert(nodes.end(), more.nodes.begin(), more.nodes.end());
      triangles.insert(triangles.end(), more.triangles.begin(), more.triangles.end());
    }
    void clear() {
      nodes.clear();
      triangles.clear();
    }
  };
  struct Selected : Nodes {
    std::vector<int> numbers;  // of pairs, as many as may be selected
  };
  // Candidates from one CandidateList: its vertex-triangle, triangle-vertex or edge-edge pairs.
  struct PairGroup : Nodes {
    bool edges = false;
    bool samples = false;  // true if the vertices belong to a dynamic body; false for edges
    // True if the vertices are centres of spheres, and if the triangles are whole spheres.
    bool of_spheres = false, on_spheres = false;
    double thickness = 0;
    double friction = 0;  // Coulomb coefficient
    int body_a = 0, body_b = 0;
    int surface = 0;  // body of the second features, for samples of the triangles
    // Neighbourhoods at rest of the samples in the surface, across seams; null if there are none.
    const bsi::Neighbourhoods* across = nullptr;
    bool is_self() const { return body_a == body_b; }
    int body_of_first() const { return surface == body_b ? body_a : body_b; }
    bool has_spheres() const { return of_spheres || on_spheres; }
    bsi::FeatureKind kind() const {
      return edges ? bsi::FeatureKind::edge_edge : bsi::FeatureKind::vertex_triangle;
    }
    Pair pair(std::size_t i) const { return {nodes[i], edges, thickness}; }
  };
  // The groups of a CandidateList. They are complete while the list has this version and does not
  // drift farther.
  struct GroupsOfList {
    std::int64_t version = -1;
    double drift = 0;  // m
    std::array<PairGroup, 3> groups;
  };
  using KeptGroups = std::vector<GroupsOfList>;  // by list
  // Lists for measuring one sample. The next sample reuses their memory.
  struct SampleScratch {
    std::vector<int> triangles;
    std::vector<bsi::SurfaceTerm> terms;
  };
  // Results of measuring one chunk of the candidates.
  struct Found : DeviceContact::Found {
    std::optional<ContactFault> fault;
    std::vector<bsi::PairInReach> in_reach;
    SampleScratch scratch;
    void clear() {
      pairs.clear();
      sliding.clear();
      mollified.clear();
      fault.reset();
      in_reach.clear();
    }
  };

  double range_of(const PairGroup& group) const;
  double path_distance(const PairGroup& group) const;
  ContactLaw law_of(const PairGroup& group, const std::array<int, 4>& nodes) const;
  bool is_dynamic(int point) const { return point < scene_.dynamic_points; }
  bool uses_device() const;
  std::optional<ContactFault> evaluate_on_device(const PlacedPoints& now,
                                                 std::span<const Vec3> velocity);
  static void make_definite(ContactPair& pair);
  void make_definite(const ContactPair& pair, Sliding& sliding) const;
  void use_secants_past_rest(std::span<const Vec3> velocity);
  void find_spins(const PlacedPoints& now, std::span<const Vec3> velocity);
  void begin_placing();
  void place_nodes(const PairGroup& group, const PlacedPoints& start, const PlacedPoints& end);
  std::optional<Vec3> obstacle_spin(const std::array<int, 4>& nodes) const;
  AnchorKey anchor_key(int point, int body, int surface) const;
  Vec3 from_anchor(const Anchor& anchor, std::span<const Vec3> position) const;
  // Free particles and obstacles make the vector from an anchor to its sample grow at these rates
  // (m/s).
  struct AnchorRates {
    Vec3 free{0, 0, 0}, obstacles{0, 0, 0};
  };
  AnchorRates rates_of(const Anchor& anchor, std::span<const Vec3> velocity) const;
  double change_by_obstacle(const std::array<int, 4>& nodes, const bsi::Closest& closest,
                            std::span<const Vec3> velocity) const;
  void place_anchors(const PlacedPoints& now);
  void describe(const CandidateList& list, int kind, PairGroup& group) const;
  void select(const CandidateList& list, std::span<const FeaturePair> pairs, float limit,
              PairGroup& group);
  void select_groups(const CandidateList& list, double sample_reach, double reach,
                     GroupsOfList& of);
  std::vector<const PairGroup*> groups_within(double sample_reach, double reach, KeptGroups& kept);
  std::vector<PairGroup> neighbours() const;
  void note_touch(const PairGroup& group, std::span<const Vec3> position);
  void measure_part(const PairGroup& group, std::size_t first, std::size_t last,
                    std::span<const Vec3> position, std::span<const Vec3> velocity,
                    Found& found) const;
  void measure_sample(const PairGroup& group, std::size_t first,
                      std::span<const bsi::PairInReach> in_reach, std::span<const Vec3> position,
                      std::span<const Vec3> velocity, Found& found) const;
  void measure_pair(const PairGroup& group, std::size_t number, std::span<const Vec3> position,
                    std::span<const Vec3> velocity, Found& found) const;
  // The law of a term of the contact of two features, with factors of its barrier and of all its
  // forces, and what else its forces depend on.
  struct PairLaw {
    ContactLaw law;
    const PairGroup* of_spheres = nullptr;  // group of the pair if a feature is a sphere
    double mollifier = 1, coefficient = 1;
    int surface = -1;                   // ContactPair::surface
    const Vec3* from_anchor = nullptr;  // m, from the sample's anchor to the sample
    Vec3 lead{0, 0, 0};                 // m, the part of it that positions do not have yet
  };
  void add_pair(const PairLaw& of, const Pair& features, const bsi::Closest& closest,
                std::span<const Vec3> position, std::span<const Vec3> velocity, Found& found) const;
  double mollify(const Pair& pair, const bsi::Closest& closest, std::span<const Vec3> position,
                 const ContactLaw& law, Found& found) const;
  void join(Found& part);
  void clear();
  double stray_of(const Pair& pair, const PointStray& stray) const;
  std::optional<Meeting> meeting_of(const Pair& pair, double range, double separation,
                                    std::span<const Vec3> start, std::span<const Vec3> end) const;
  // The conditions that a path must meet.
  struct PathDemand {
    // If true, features must keep half the thickness on the path and the whole thickness at its
    // end.
    bool gap = true;
    PointStray stray;
    CurveStray curve;
  };
  std::optional<ContactFault> find_path_fault(const PlacedPoints& start, const PlacedPoints& end,
                                              const PathDemand& demand);
  std::optional<ContactFault> check_part(const PairGroup& group, std::size_t first,
                                         std::size_t last, std::span<const Vec3> start,
                                         std::span<const Vec3> end, const PathDemand& demand,
                                         std::vector<OpenPair>& open) const;

  const Scene& scene_;
  Statistics& statistics_;
  ContactSearch search_;
  double range_, damping_time_, friction_speed_;
  double hold_rate_ = 0;                    // ContactLaw::hold_rate
  const AnchorHistory* anchors_ = nullptr;  // null: contacts are not anchored
  std::span<const Vec3> measured_at_;       // positions of the last evaluate(), m
  PairFriction friction_;
  SphereContactLaws spheres_;
  bool definite_ = false;
  // Number of evaluations since begin_newton(), which is that of the next iterate. Negative without
  // begin_newton().
  int iterate_ = -1;
  double newton_step_ = 0;  // s, see begin_newton()
  // Velocities of dynamic points (m/s) at the last iterate. Empty without begin_newton().
  std::vector<Vec3> last_velocity_;
  std::vector<Vec3> rest_;                   // rest positions of all points, m
  std::vector<int> case_index_;              // by body, its number in the case
  std::vector<bsi::SurfaceTerms> surfaces_;  // by body
  KeptGroups in_range_, on_path_;            // for evaluate() and find_path_fault()
  std::vector<double> body_reach_;           // m, by body: strays of a path and of curved surfaces
  std::vector<OpenPair> open_;
  std::vector<int> moving_obstacles_;  // indices of bodies that move and are not dynamic
  PlacedMarks marks_;
  // Angular velocities, rad/s, by body; zero except for moving obstacles.
  std::vector<Vec3> obstacle_spins_;
  std::vector<char> touched_;
  std::vector<ContactPair> pairs_;
  std::size_t added_pairs_ = 0;  // number of pairs of add_pair(), at the end of pairs_
  std::vector<Sliding> sliding_;
  std::vector<MollifierForce> mollified_;
  // By chunk of the last loop: the pairs selected, and what was found.
  std::vector<Selected> selected_;
  std::vector<Found> found_;
  std::unique_ptr<DeviceContact> device_;  // null if the CPU evaluates
  std::int64_t on_device_ = -1;            // ContactSearch::changes() of the device's candidates
};

}  // namespace weft::sim
