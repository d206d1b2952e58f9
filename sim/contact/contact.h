// Contact forces: barrier, contact damping and friction per area of the surfaces in reach, smooth
// functions of the state, so that the integrator's error control covers them.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bsi/detail/feature_batches.h"
#include "bsi/proximity.h"
#include "bsi/surface_terms.h"
#include "sim/base/statistics.h"
#include "sim/contact/contact_pair.h"
#include "sim/contact/contact_search.h"
#include "sim/matrix/block_matrix.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Why a state or a step cannot be taken.
struct ContactFault {
  enum class Kind { not_finite, touching, crossing, in_reach };
  Kind kind = Kind::touching;
  std::array<int, 4> nodes{-1, -1, -1,
                           -1};  // the pair (global particles); not_finite: the first only
  double gap = 0;                // m
  std::string describe(const Scene& scene) const;
};

// How far (m) points may be from their straight paths, at the most: by body, the largest of its
// particles, and by dynamic particle. Both empty where all paths are straight.
struct PathStray {
  std::span<const double> body, particle;
};

// Each vertex of a dynamic surface is a sample with the area around it. It meets another surface,
// or its own beyond the triangles around it, by the signed sum over that surface's features in
// range (bsi/surface_terms.h), which counts the surface once: the force is one per area, whatever
// the meshes. Where both surfaces are dynamic the samples of both count half. What samples do not
// see, two edges, or an obstacle's vertex inside a triangle, has a barrier of its own over the last
// quarter of the range: as much energy on a shorter way.
//
// A pair (or term) at distance d, with gap g = d - thickness below its range, pushes along its
// normal with barrier and damping together (materials/contact.h) and rubs across it (Sliding,
// contact_pair.h). The Newton matrix keeps, per pair, the slopes of push and friction along the
// closest points. How the mollifier, the normal and the friction's limit change with x is left to
// the iteration.
class Contact {
 public:
  Contact(const Scene& scene, Statistics& statistics, ChosenSearch search);
  // On the CPU.
  Contact(const Scene& scene, Statistics& statistics)
      : Contact(scene, statistics, {make_cpu_search(scene), {}}) {}

  // Finds the pairs in reach and their forces. `position` and `velocity` are of all particles (m,
  // m/s).
  [[nodiscard]] std::optional<ContactFault> evaluate(const PlacedParticles& now,
                                                     std::span<const Vec3> velocity, int threads);
  [[nodiscard]] std::optional<ContactFault> evaluate(std::span<const Vec3> position,
                                                     std::span<const Vec3> velocity, int threads) {
    return evaluate(PlacedParticles(position), velocity, threads);
  }
  // The rest is about the last evaluate(); arrays are of the dynamic particles. The forces may be
  // wanted of all, obstacles too: they are added on the first force.size() particles.
  void add_forces(std::span<Vec3> force) const;
  // Replaces `particles` by those of obstacles on which add_forces() would act, in order.
  void find_loaded_obstacles(std::vector<int>& particles) const;
  double energy() const;
  // Adds (gamma^2 K + gamma D) * in, and its diagonal blocks.
  void add_product(double gamma, std::span<const Vec3> in, std::span<Vec3> out) const;
  // Subtracts factor * K * in.
  void subtract_stiffness(double factor, std::span<const Vec3> in, std::span<Vec3> out) const;
  void add_diagonal(double gamma, std::span<Mat3> diagonal) const;
  // Calls visit(row, column, block) for every block of gamma^2 K + gamma D, pair by pair.
  template <class Visit>
  void visit_blocks(double gamma, const Visit& visit) const;
  // From now on, leaves out of the matrix what is negative along a normal, of pairs that part fast
  // and of terms that are subtracted: for long fixed steps.
  void keep_matrix_definite() { definite_ = true; }
  const std::array<int, 4>& pair_nodes(std::size_t pair) const { return pairs_[pair].nodes; }
  double pair_gap(std::size_t pair) const { return pairs_[pair].gap; }  // m
  // The part of one pair in reach: weight_i weight_j block between its nodes i and j, where these
  // are dynamic. Made positive semi-definite, for preconditioners; there friction has no levers.
  struct Coupling {
    std::array<int, 4> nodes;
    std::array<double, 4> weight;
    Mat3 block;
  };
  Coupling definite_coupling(std::size_t pair, double gamma) const;
  const RigidObstacles& obstacles() const { return search_.obstacles(); }
  // The search runs on this.
  const ComputeChoice& compute() const { return search_.compute(); }
  std::size_t pairs_in_reach() const { return pairs_.size(); }
  // Marks, by body: the sleeping bodies that a feature of a dynamic body was in range of in an
  // evaluation since the last forget_touched().
  std::span<const char> touched() const { return touched_; }
  void forget_touched() { std::ranges::fill(touched_, 0); }
  // Smallest gap of the pairs in reach; nothing where there are none.
  std::optional<double> smallest_gap() const;

  // Is every pair of features certain to keep apart along the straight paths start -> end, and on
  // all paths no further from these than `stray`, and to end with a positive gap?
  [[nodiscard]] std::optional<ContactFault> check_path(const PlacedParticles& start,
                                                       const PlacedParticles& end,
                                                       const PathStray& stray = {});
  [[nodiscard]] std::optional<ContactFault> check_path(std::span<const Vec3> start,
                                                       std::span<const Vec3> end,
                                                       const PathStray& stray = {}) {
    return check_path(PlacedParticles(start), PlacedParticles(end), stray);
  }
  // Checks the path to a place on a path that has been found free: no gap is demanded, at its end
  // or on the way, only that surfaces do not meet.
  [[nodiscard]] std::optional<ContactFault> check_crossing(const PlacedParticles& start,
                                                           const PlacedParticles& end);
  // Smallest gap within the range at `position` (infinite where none is); a fault where one is not
  // positive.
  [[nodiscard]] std::optional<ContactFault> check_state(std::span<const Vec3> position,
                                                        double* smallest_gap);
  // A pair of features of one body closer than thickness + range at `position`, if any.
  [[nodiscard]] std::optional<ContactFault> self_pair_in_reach(std::span<const Vec3> position);

 private:
  // Forces that the mollifier of near-parallel edges adds to the forces on the four nodes.
  struct MollifierForce {
    std::array<int, 4> nodes{};
    std::array<Vec3, 4> force;
  };
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
    int surface = 0;  // the body of the triangles, of samples
    bool is_self() const { return body_a == body_b; }
    std::vector<bsi::FourParticles> nodes;
    std::vector<int> triangles;  // local to the body, of samples
    bsi::FeatureKind kind() const {
      return edges ? bsi::FeatureKind::edge_edge : bsi::FeatureKind::vertex_triangle;
    }
    Pair pair(std::size_t i) const { return {nodes[i], edges, thickness}; }
  };
  // The share of the forces of one part of the candidates.
  struct Found {
    std::vector<ContactPair> pairs;
    std::vector<Sliding> sliding;
    std::vector<MollifierForce> mollified;
    std::optional<ContactFault> fault;
  };

  template <class Block>
  void add_pair_products(const Block& block, std::span<const Vec3> in, std::span<Vec3> out) const;
  void add_sliding_products(double factor, std::span<const Vec3> in, std::span<Vec3> out) const;
  template <class Visit>
  void visit_candidates(double reach, const Visit& visit) const;
  std::array<int, 4> nodes_of(const CandidateList& list, int kind,
                              const FeaturePair& features) const;
  double pair_area(const std::array<int, 4>& nodes, int split) const;
  double range_of(const PairGroup& group) const;
  bool is_dynamic(int particle) const { return particle < scene_.dynamic_particles; }
  void find_spins(const PlacedParticles& now, std::span<const Vec3> velocity);
  void begin_placing();
  void place_nodes(const PairGroup& group, const PlacedParticles& start,
                   const PlacedParticles& end);
  std::optional<Vec3> obstacle_spin(const std::array<int, 4>& nodes) const;
  double normal_block(const ContactPair& pair, double gamma) const {
    return gamma * (gamma * pair.stiffness + pair.damping);
  }
  std::vector<PairGroup> groups_within(double sample_reach, double reach) const;
  void note_touch(const PairGroup& group, std::span<const Vec3> position);
  void measure_part(const PairGroup& group, std::size_t first, std::size_t last,
                    std::span<const Vec3> position, std::span<const Vec3> velocity,
                    Found& found) const;
  // Lists of one sample, kept from one to the next for their memory.
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
  double stray_of(const Pair& pair, const PathStray& stray) const;
  // The conditions that a path must meet.
  struct PathDemand {
    bool gap = true;  // half the thickness on the way and all of it at the end
    PathStray stray;
  };
  std::optional<ContactFault> find_path_fault(const PlacedParticles& start,
                                              const PlacedParticles& end, const PathDemand& demand);
  std::optional<ContactFault> check_part(const PairGroup& group, std::size_t first,
                                         std::size_t last, std::span<const Vec3> start,
                                         std::span<const Vec3> end, const PathDemand& demand) const;

  const Scene& scene_;
  Statistics& statistics_;
  ContactSearch search_;
  double range_, stiffness_, damping_time_, friction_, friction_speed_;
  bool definite_ = false;
  std::vector<Vec3> rest_;                   // of all particles: edge lengths scale the mollifier
  std::vector<bsi::SurfaceTerms> surfaces_;  // by body
  std::vector<int> moving_obstacles_;        // bodies
  PlacedMarks marks_;
  std::vector<Vec3> spins_;  // rad/s, by body; zero but of moving obstacles
  std::vector<char> touched_;
  std::vector<ContactPair> pairs_;
  std::vector<Sliding> sliding_;
  std::vector<MollifierForce> mollified_;
};

template <class Visit>
void Contact::visit_blocks(double gamma, const Visit& visit) const {
  for (const ContactPair& pair : pairs_) {
    const Mat3 along = normal_block(pair, gamma) * pair.normal * pair.normal.transpose();
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const int row = pair.nodes[i], column = pair.nodes[j];
        if (!is_dynamic(row) || !is_dynamic(column)) continue;
        Mat3 block = pair.weight[i] * pair.weight[j] * along;
        if (pair.sliding >= 0) {
          const Sliding& sliding = sliding_[pair.sliding];
          block += gamma * sliding.lever[i].transpose() * sliding.slope * sliding.lever[j];
        }
        visit(row, column, block);
      }
    }
  }
}

}  // namespace weft::sim
