// Contact forces: barrier, contact damping and friction on every pair of features in reach, smooth
// functions of the state, so that the integrator's error control covers them.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bsi/feature_batches.h"
#include "bsi/proximity.h"
#include "sim/contact/contact_search.h"
#include "sim/forces/block_matrix.h"
#include "sim/scene/scene.h"
#include "sim/statistics.h"

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
// particles, and by particle. Both empty where all paths are straight.
struct PathStray {
  std::span<const double> body, particle;
};

// For a pair at distance d, with gap g = d - thickness < range:
//   barrier         W = m(c) b(g), force -dW/dx  (materials/contact.h; m is 1 but for near-parallel
//   edges) contact damping F_n = -beta W''(g) g'        (along the normal) friction        F_t =
//   -mu N f(|v_t|)/|v_t| v_t  (N = -W'(g), not lagged)
// with v_t the relative velocity of the closest points across the normal. The Newton matrix keeps,
// per pair, a 3x3 block between the closest points: the stiffness (W'' + beta W''' g') n n^T and
// the slopes of damping and friction in the velocity. How the mollifier, the normal and the push
// turn with x is left to the iteration.
class Contact {
 public:
  Contact(const Scene& scene, Statistics& statistics, ChosenSearch search);
  // On the CPU.
  Contact(const Scene& scene, Statistics& statistics)
      : Contact(scene, statistics, {make_cpu_search(scene), {}}) {}

  // Finds the pairs in reach and their forces. `position` and `velocity` are of all particles (m,
  // m/s).
  [[nodiscard]] std::optional<ContactFault> evaluate(std::span<const Vec3> position,
                                                     std::span<const Vec3> velocity, int threads);
  // The rest is about the last evaluate(); arrays are of the dynamic particles.
  void add_forces(std::span<Vec3> force) const;
  double energy() const;
  // Adds (gamma^2 K + gamma D) * in, and its diagonal blocks.
  void add_product(double gamma, std::span<const Vec3> in, std::span<Vec3> out) const;
  // Subtracts factor * K * in.
  void subtract_stiffness(double factor, std::span<const Vec3> in, std::span<Vec3> out) const;
  void add_diagonal(double gamma, std::span<Mat3> diagonal) const;
  // Calls visit(row, column, block) for every block of gamma^2 K + gamma D, pair by pair.
  template <class Visit>
  void visit_blocks(double gamma, const Visit& visit) const;
  // From now on, leaves out of the matrix the stiffness of pairs that part so fast that it would
  // push the wrong way: for long fixed steps.
  void keep_matrix_definite() { definite_ = true; }
  const std::array<int, 4>& pair_nodes(std::size_t pair) const { return active_[pair].nodes; }
  // The part of one pair in reach: weight_i weight_j block between its nodes i and j, where these
  // are dynamic. Made positive semi-definite, for preconditioners.
  struct Coupling {
    std::array<int, 4> nodes;
    std::array<double, 4> weight;
    Mat3 block;
  };
  Coupling definite_coupling(std::size_t pair, double gamma) const;
  // What its search runs on.
  const ComputeChoice& compute() const { return search_.compute(); }
  std::size_t pairs_in_reach() const { return active_.size(); }
  // Smallest gap of the pairs in reach; nothing where there are none.
  std::optional<double> smallest_gap() const;

  // Is every pair of features certain to keep apart along the straight paths start -> end, and on
  // all paths no further from these than `stray`, and to end with a positive gap?
  [[nodiscard]] std::optional<ContactFault> check_path(std::span<const Vec3> start,
                                                       std::span<const Vec3> end,
                                                       const PathStray& stray = {});
  // The same for a place on a path that has been found free: no gap is demanded, at its end or on
  // the way, only that surfaces do not meet.
  [[nodiscard]] std::optional<ContactFault> check_crossing(std::span<const Vec3> start,
                                                           std::span<const Vec3> end);
  // Smallest gap within the range at `position` (infinite where none is); a fault where one is not
  // positive.
  [[nodiscard]] std::optional<ContactFault> check_state(std::span<const Vec3> position,
                                                        double* smallest_gap);
  // A pair of features of one body closer than thickness + range at `position`, if any.
  [[nodiscard]] std::optional<ContactFault> self_pair_in_reach(std::span<const Vec3> position);

 private:
  struct Active {
    std::array<int, 4> nodes{};
    std::array<double, 4> weight{};
    double gap = 0;
    double energy = 0;
    Vec3 force{0, 0, 0};  // on the first feature's closest point, N
    Mat3 stiffness = Mat3::Zero();
    Mat3 damping = Mat3::Zero();
  };
  // What the mollifier of near-parallel edges adds to the forces on the four nodes.
  struct MollifierForce {
    std::array<int, 4> nodes{};
    std::array<Vec3, 4> force;
  };
  struct Pair {
    std::array<int, 4> nodes{};
    bool edges = false;
    double thickness = 0;
  };
  // Pairs of one list and kind.
  struct PairGroup {
    bool edges = false;
    double thickness = 0;
    int body_a = 0, body_b = 0;
    std::vector<bsi::FourParticles> nodes;
    bsi::FeatureKind kind() const {
      return edges ? bsi::FeatureKind::edge_edge : bsi::FeatureKind::vertex_triangle;
    }
    Pair pair(std::size_t i) const { return {nodes[i], edges, thickness}; }
  };
  // What a part of the pairs adds to the forces.
  struct Found {
    std::vector<Active> active;
    std::vector<MollifierForce> mollified;
    std::optional<ContactFault> fault;
  };
  enum class Reach { out, in, touching };

  template <class Block>
  void add_pair_products(const Block& block, std::span<const Vec3> in, std::span<Vec3> out) const;
  template <class Visit>
  void visit_candidates(double reach, const Visit& visit) const;
  std::array<int, 4> nodes_of(const CandidateList& list, int kind,
                              const FeaturePair& features) const;
  double pair_area(const std::array<int, 4>& nodes, int split) const;
  Reach measure(const Pair& pair, std::span<const Vec3> position, std::span<const Vec3> velocity,
                Active& active, MollifierForce& mollified, bool& has_mollified) const;
  void add_damping_and_friction(const bsi::Closest& closest, const Vec3& relative_velocity,
                                double slope, double curvature, double third, Active& active) const;
  double mollify(const Pair& pair, std::span<const Vec3> position, double barrier_value,
                 MollifierForce& mollified, bool& has_mollified) const;
  std::vector<PairGroup> groups_within(double reach) const;
  void measure_part(const PairGroup& group, std::size_t first, std::size_t last,
                    std::span<const Vec3> position, std::span<const Vec3> velocity,
                    Found& found) const;
  static double stray_of(const Pair& pair, std::span<const double> stray);
  // What a path must keep to.
  struct PathDemand {
    bool gap = true;  // half the thickness on the way and all of it at the end
    PathStray stray;
  };
  std::optional<ContactFault> find_path_fault(std::span<const Vec3> start,
                                              std::span<const Vec3> end, const PathDemand& demand);
  std::optional<ContactFault> check_part(const PairGroup& group, std::size_t first,
                                         std::size_t last, std::span<const Vec3> start,
                                         std::span<const Vec3> end, const PathDemand& demand) const;

  const Scene& scene_;
  Statistics& statistics_;
  ContactSearch search_;
  double range_, stiffness_, damping_time_, friction_, friction_speed_;
  bool definite_ = false;
  std::vector<Vec3> rest_;  // of all particles: edge lengths scale the mollifier
  std::vector<Active> active_;
  std::vector<MollifierForce> mollified_;
};

template <class Visit>
void Contact::visit_blocks(double gamma, const Visit& visit) const {
  for (const Active& active : active_) {
    const Mat3 block = gamma * (gamma * active.stiffness + active.damping);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const int row = active.nodes[i], column = active.nodes[j];
        if (row >= scene_.dynamic_particles || column >= scene_.dynamic_particles) continue;
        visit(row, column, Mat3(active.weight[i] * active.weight[j] * block));
      }
    }
  }
}

}  // namespace weft::sim
