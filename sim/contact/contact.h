// Contact forces on particles, made from those on surface points, and their matrices.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/contact/surface_contact.h"
#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// Positions of all particles at one time, m. With `poses`, one for each of RigidObstacles::all(),
// the positions of these obstacles need not be given. They may then be overwritten, and so may the
// obstacles' velocities, if there are any.
struct PlacedParticles {
  // Everything is given.
  PlacedParticles(std::span<const Vec3> given) : position(given) {}  // NOLINT: implicit
  PlacedParticles(std::span<Vec3> given, std::span<Vec3> rates, std::span<const RigidPose> places)
      : position(given), room(given), velocity(rates), poses(places) {}

  std::span<const Vec3> position;
  std::span<Vec3> room, velocity;
  std::span<const RigidPose> poses;
};

// Upper bounds (m) of the distances of particles from their straight paths: by body, of all its
// particles, and by dynamic particle. Both are empty if all paths are straight.
struct PathStray {
  std::span<const double> body, particle;
};

// A force (N) and the moment (N m) about the origin of all of its parts.
struct Wrench {
  Vec3 force{0, 0, 0}, moment{0, 0, 0};
  void add(const Vec3& place, const Vec3& part) {
    force += part;
    moment += place.cross(part);
  }
};

// Turns particles into surface points, x = S x and v = S v (sim/scene/surface_map.h), finds the
// contact of these (SurfaceContact), and returns its forces by the transpose: f = S^T f. If all
// points are particles, nothing is copied.
//
// The Newton matrix S^T A S has, per pair, the slopes of push and friction at the closest points.
// It leaves out how the mollifier, the normal and the limit of friction change with x.
class Contact {
 public:
  Contact(const Scene& scene, Statistics& statistics, ChosenSearch search);
  // Searches on the CPU.
  Contact(const Scene& scene, Statistics& statistics)
      : Contact(scene, statistics, {make_cpu_search(scene), {}}) {}

  // Finds the pairs in reach and their forces. `velocity` is of all particles (m/s).
  [[nodiscard]] std::optional<ContactFault> evaluate(const PlacedParticles& now,
                                                     std::span<const Vec3> velocity, int threads);
  [[nodiscard]] std::optional<ContactFault> evaluate(std::span<const Vec3> position,
                                                     std::span<const Vec3> velocity, int threads) {
    return evaluate(PlacedParticles(position), velocity, threads);
  }
  // Results below are those of the last evaluate(), except for touched(). Arrays have one entry per
  // dynamic particle. `force` may have one per particle: obstacles then get their forces, too.
  void add_forces(std::span<Vec3> force) const;
  // Adds these forces in two parts: along normals, contact damping included, and friction. Both
  // lists have one entry per dynamic particle, or one per particle.
  void add_forces(std::span<Vec3> normal, std::span<Vec3> friction) const;
  // Adds the wrench of each non-dynamic body on dynamic particles at `position` (m) to its entry of
  // `by_body`.
  void add_wrenches(std::span<const Vec3> position, std::span<Wrench> by_body) const;
  // Replaces `particles` by the particles of obstacles on which add_forces() would act, in order.
  void find_loaded_obstacles(std::vector<int>& particles) const;
  double energy() const;
  // Adds (gamma^2 K + gamma D) * in to `out`.
  void add_product(double gamma, std::span<const Vec3> in, std::span<Vec3> out) const;
  // Subtracts factor * K * in from `out`.
  void subtract_stiffness(double factor, std::span<const Vec3> in, std::span<Vec3> out) const;
  // Adds the diagonal blocks of gamma^2 K + gamma D.
  void add_diagonal(double gamma, std::span<Mat3> diagonal) const;
  // Calls visit(row, column, block) for every block of gamma^2 K + gamma D, pair by pair.
  template <class Visit>
  void visit_blocks(double gamma, const Visit& visit) const;
  // Sets the Coulomb coefficient from now on.
  void set_friction(double friction) { surface_.set_friction(friction); }
  // From now on, sets negative stiffness and damping of pairs, and the friction slope of subtracted
  // terms, to zero: for long fixed steps.
  void keep_matrix_definite() { surface_.keep_matrix_definite(); }
  // The part of the matrix that one pair in reach adds: weight_i weight_j block between its
  // particles i and j, if both are dynamic. The block is made positive semi-definite, for
  // preconditioners. Friction enters by the weights, as if its levers equalled them.
  struct Coupling {
    std::span<const int> particles;  // each once
    std::span<const double> weights;
    Mat3 block;
  };
  // Calls visit(coupling) for every pair in reach.
  template <class Visit>
  void visit_definite_couplings(double gamma, const Visit& visit) const;
  const RigidObstacles& obstacles() const { return surface_.obstacles(); }
  // The device that the search runs on.
  const ComputeChoice& compute() const { return surface_.compute(); }
  std::size_t pairs_in_reach() const { return surface_.pairs().size(); }
  // The pairs in reach; their nodes are surface points.
  std::span<const ContactPair> pairs() const { return surface_.pairs(); }
  // Returns the marks of SurfaceContact::touched(), by body.
  std::span<const char> touched() const { return surface_.touched(); }
  void forget_touched() { surface_.forget_touched(); }
  // Smallest gap (m) of the pairs in reach; nothing if there are none.
  std::optional<double> smallest_gap() const;

  // Returns a fault unless every pair of features is certain to keep apart and to end with a
  // positive gap: on the straight paths start -> end, and on all paths no farther from these than
  // `stray`.
  [[nodiscard]] std::optional<ContactFault> check_path(const PlacedParticles& start,
                                                       const PlacedParticles& end,
                                                       const PathStray& stray = {});
  [[nodiscard]] std::optional<ContactFault> check_path(std::span<const Vec3> start,
                                                       std::span<const Vec3> end,
                                                       const PathStray& stray = {}) {
    return check_path(PlacedParticles(start), PlacedParticles(end), stray);
  }
  // Checks part of the straight path of a step that has been found free: up to a point on it. No
  // gap is required there or on the way; surfaces need only not meet.
  [[nodiscard]] std::optional<ContactFault> check_crossing(const PlacedParticles& start,
                                                           const PlacedParticles& end);
  // Finds the smallest gap (m) within the range at `position`; infinite if there is none. Returns a
  // fault if a gap is not positive.
  [[nodiscard]] std::optional<ContactFault> check_state(std::span<const Vec3> position,
                                                        double* smallest_gap);
  // Returns a pair of features of one body closer than thickness + range at `position`, if any.
  [[nodiscard]] std::optional<ContactFault> self_pair_in_reach(std::span<const Vec3> position);

 private:
  // All surface points at one time, if they are not the particles.
  struct Points {
    std::vector<Vec3> position, velocity;
  };
  // A pair by particles: those of its four points, each once, with their weights in the separation
  // of the closest points and, if there is friction, their levers (Sliding).
  struct Stencil {
    std::span<const int> particles;
    std::span<const double> weights;
    std::span<const Mat3> levers;
  };
  struct StencilRoom {
    std::vector<int> particles;
    std::vector<double> weights;
    std::vector<Mat3> levers;
  };

  std::span<const Vec3> all_points(std::span<const Vec3> position) {
    return scene_.surface_map.points_of(position, scene_.point_count, now_.position);
  }
  PlacedPoints on_surface(const PlacedParticles& now, Points& points) const;
  void map_bodies(bool obstacles_too, std::span<const Vec3> from, std::vector<Vec3>& to) const;
  PointStray on_surface(const PathStray& stray);
  std::optional<ContactFault> on_particles(std::optional<ContactFault> fault,
                                           std::span<const Vec3> position) const;
  template <class Use>
  void with_map(const Use& use) const;
  void add_forces_to(std::span<Vec3> normal, std::span<Vec3> friction) const;
  template <class Block>
  void add_pair_products(const Block& block, std::span<const Vec3> in, std::span<Vec3> out) const;
  void add_sliding_products(double factor, std::span<const Vec3> in, std::span<Vec3> out) const;
  Stencil stencil(const ContactPair& pair, StencilRoom& room) const;
  Stencil joined_stencil(const ContactPair& pair, StencilRoom& room) const;
  bool is_dynamic(int particle) const { return particle < scene_.dynamic_particles; }
  static double normal_block(const ContactPair& pair, double gamma) {
    return gamma * (gamma * pair.stiffness + pair.damping);
  }
  Mat3 definite_block(const ContactPair& pair, double gamma) const;

  const Scene& scene_;
  SurfaceContact surface_;
  Points now_, start_, end_;                      // the latter two of a path
  std::vector<double> body_stray_, point_stray_;  // m
};

template <class Visit>
void Contact::visit_blocks(double gamma, const Visit& visit) const {
  StencilRoom room;
  for (const ContactPair& pair : surface_.pairs()) {
    const Mat3 along = normal_block(pair, gamma) * pair.normal * pair.normal.transpose();
    const Stencil of = stencil(pair, room);
    for (std::size_t i = 0; i < of.particles.size(); ++i) {
      for (std::size_t j = 0; j < of.particles.size(); ++j) {
        const int row = of.particles[i], column = of.particles[j];
        if (!is_dynamic(row) || !is_dynamic(column)) continue;
        Mat3 block = of.weights[i] * of.weights[j] * along;
        if (pair.sliding >= 0) {
          block += gamma * of.levers[i].transpose() * surface_.sliding(pair.sliding).slope *
                   of.levers[j];
        }
        visit(row, column, block);
      }
    }
  }
}

template <class Visit>
void Contact::visit_definite_couplings(double gamma, const Visit& visit) const {
  StencilRoom room;
  for (const ContactPair& pair : surface_.pairs()) {
    const Stencil of = stencil(pair, room);
    visit(Coupling{of.particles, of.weights, definite_block(pair, gamma)});
  }
}

}  // namespace weft::sim
