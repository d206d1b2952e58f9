// Contact forces on particles and their stiffness and damping matrices. They are computed from
// contact forces on surface points.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/contact/contact_pair.h"
#include "sim/contact/curved_paths.h"
#include "sim/contact/surface_contact.h"
#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// Positions of all particles at one time, m. `poses` may have one pose per obstacle of
// RigidObstacles::all(). If it is given, the positions of these obstacles need not be valid.
// Contact may write positions of the obstacles to `room`, and their velocities (m/s) to `velocity`
// unless `velocity` is empty.
struct PlacedParticles {
  // Takes the positions of all particles, without poses.
  PlacedParticles(std::span<const Vec3> given, double at = 0)  // NOLINT: implicit
      : position(given), time(at) {}
  PlacedParticles(std::span<Vec3> given, std::span<Vec3> rates, std::span<const RigidPose> places,
                  double at = 0)
      : position(given), room(given), velocity(rates), poses(places), time(at) {}

  std::span<const Vec3> position;
  std::span<Vec3> room, velocity;
  std::span<const RigidPose> poses;
  double time = 0;  // s, as PlacedPoints::time()
};

// Upper bounds (m) of the distances of particles from their straight paths. `body` has one bound
// for all particles of each body, `particle` one per dynamic particle. Both lists are empty if all
// paths are straight.
struct PathStray {
  std::span<const double> body, particle;
};

// A sum of forces (N) and of their moments about the origin (N m).
struct Wrench {
  Vec3 force{0, 0, 0}, moment{0, 0, 0};
  void add(const Vec3& place, const Vec3& part) {
    force += part;
    moment += place.cross(part);
  }
};

// The path of a step: straight paths of all particles (m) but for `stray`, within `duration` (s).
struct StepPath {
  PlacedParticles start, end;
  PathStray stray;
  double duration = 0;
};

// Contact of surfaces as forces on particles. Positions x and velocities v of particles give those
// of surface points, S x and S v (sim/scene/surface_map.h). SurfaceContact finds the contact forces
// g on these points, and the transpose maps them to forces on particles, f = S^T g. If all points
// are particles, nothing is copied.
//
// K = -df/dx and D = -df/dv are the stiffness and damping matrices. They contain, for each pair,
// the slopes of push and friction at the closest points. The slopes of the mollifier, of the normal
// and of the friction limit are neglected.
class Contact {
 public:
  Contact(const Scene& scene, Statistics& statistics, ChosenSearch search);
  // Searches on the CPU.
  Contact(const Scene& scene, Statistics& statistics)
      : Contact(scene, statistics, {make_cpu_search(scene), {}}) {}

  // Finds the pairs in reach and their forces. `velocity` has one entry per particle (m/s). Returns
  // a fault if a position is not finite or a gap is not positive.
  [[nodiscard]] std::optional<ContactFault> evaluate(const PlacedParticles& now,
                                                     std::span<const Vec3> velocity, int threads);
  [[nodiscard]] std::optional<ContactFault> evaluate(std::span<const Vec3> position,
                                                     std::span<const Vec3> velocity, int threads) {
    return evaluate(PlacedParticles(position), velocity, threads);
  }
  // Adds the contact forces (N) of the last evaluate() to `force`. `force` has one entry per
  // dynamic particle, or one per particle. In the second case, the particles of obstacles get
  // forces, too.
  void add_forces(std::span<Vec3> force) const;
  // Adds the contact forces (N) of the last evaluate() to two lists: friction to `friction`, all
  // other forces to `normal`. Both lists have one entry per dynamic particle, or one per particle.
  void add_forces(std::span<Vec3> normal, std::span<Vec3> friction) const;
  // Adds to by_body[b] the wrench of the contact forces that body b exerts on dynamic particles,
  // for each body b that is not dynamic. `position` has the positions of all particles, m.
  void add_wrenches(std::span<const Vec3> position, std::span<Wrench> by_body) const;
  // Sets `particles` to the particles of obstacles to which add_forces() adds forces, in ascending
  // order.
  void find_loaded_obstacles(std::vector<int>& particles) const;
  double energy() const;
  // Adds (gamma^2 K + gamma D) * in to `out`. Both have one entry per dynamic particle, and gamma
  // is a time (s). K and D are those of the last evaluate().
  void add_product(double gamma, std::span<const Vec3> in, std::span<Vec3> out) const;
  // Subtracts factor * K * in from `out`.
  void subtract_stiffness(double factor, std::span<const Vec3> in, std::span<Vec3> out) const;
  // Adds the diagonal blocks of gamma^2 K + gamma D to `diagonal`. Returns the particles that they
  // belong to, with repetitions.
  std::vector<int> add_diagonal(double gamma, std::span<Mat3> diagonal) const;
  // Calls visit(row, column, block) for the part of each pair in each block of gamma^2 K + gamma D.
  // A block is the sum of its parts.
  template <class Visit>
  void visit_blocks(double gamma, const Visit& visit) const;
  // Sets the Coulomb coefficient, in later evaluations, of bodies for which no [[contact.pair]]
  // holds.
  void set_friction(double friction) { surface_.set_friction(friction); }
  // Makes the matrices of later evaluations positive semi-definite, for long fixed steps. Negative
  // stiffness and damping of pairs, and the friction slope of subtracted terms, are set to zero.
  void keep_matrix_definite() { surface_.keep_matrix_definite(); }
  // Call the functions of SurfaceContact with these names.
  void begin_newton(double step = 0) { surface_.begin_newton(step); }
  void end_newton() { surface_.end_newton(); }
  double step_ahead() const { return surface_.step_ahead(); }
  void use_anchors(const AnchorHistory& anchors) { surface_.use_anchors(anchors); }
  void advance_anchors(Anchors& anchors) const { surface_.advance_anchors(anchors); }
  // A part of one pair in gamma^2 K + gamma D, for preconditioners. Its block for two dynamic
  // particles i and j is weight_i weight_j `block`. `block` is positive semi-definite. For
  // friction, the weights replace the levers. The spin of a sphere has a part of its own.
  struct Coupling {
    std::span<const int> particles;  // no particle occurs twice
    std::span<const double> weights;
    Mat3 block;
  };
  // Calls visit(coupling) for every part of every pair in reach.
  template <class Visit>
  void visit_definite_couplings(double gamma, const Visit& visit) const;
  const RigidObstacles& obstacles() const { return surface_.obstacles(); }
  // Returns the processor that runs the contact search.
  const ComputeChoice& compute() const { return surface_.compute(); }
  std::size_t pairs_in_reach() const { return surface_.pairs().size(); }
  // Returns the pairs in reach at the last evaluate(). Their nodes are surface points.
  std::span<const ContactPair> pairs() const { return surface_.pairs(); }
  // Sets one mark per dynamic particle, nonzero for particles of the pairs in reach at the last
  // evaluate().
  void mark_particles_in_reach(std::vector<char>& marks) const;
  // Returns one mark per body, nonzero for sleeping bodies that a dynamic body has touched
  // (SurfaceContact::touched()).
  std::span<const char> touched() const { return surface_.touched(); }
  void forget_touched() { surface_.forget_touched(); }
  // Returns the smallest gap (m) of the pairs in reach at the last evaluate(), or nothing if there
  // are no such pairs.
  std::optional<double> smallest_gap() const;
  // Returns the largest change of a gap of a pair in reach, as a fraction of the gap at the last
  // evaluation, if the dynamic particles move from `from` to `to` (m). The change of a pair that
  // has closed by more than its gap since the positions `start` counts `closing_factor` times. To
  // first order. O(pairs).
  double largest_relative_gap_change(std::span<const Vec3> start, std::span<const Vec3> from,
                                     std::span<const Vec3> to, double closing_factor) const;

  // Returns a fault unless every pair of features that ContactSearch covers provably stays apart
  // and ends with a positive gap. The proof covers the straight paths start -> end and all paths
  // that deviate from them by at most `stray`. The curved surfaces of shells, too, provably stay
  // apart: features keep a distance no smaller than the distances by which the surfaces may leave
  // their triangles at the start or the end (raise_to_deviations()), or smaller triangles on the
  // surfaces do (CurvedPaths).
  [[nodiscard]] std::optional<ContactFault> check_path(const PlacedParticles& start,
                                                       const PlacedParticles& end,
                                                       const PathStray& stray = {});
  [[nodiscard]] std::optional<ContactFault> check_path(std::span<const Vec3> start,
                                                       std::span<const Vec3> end,
                                                       const PathStray& stray = {}) {
    return check_path(PlacedParticles(start), PlacedParticles(end), stray);
  }
  // Checks the first part, start -> end, of the straight path of a step. Returns a fault if
  // surfaces may meet on it. Unlike check_path(), it does not require a gap.
  [[nodiscard]] std::optional<ContactFault> check_crossing(const PlacedParticles& start,
                                                           const PlacedParticles& end);
  // A stop is a damper on a pair of features that would meet during a long step. It slows their
  // approach at the end of the step to the speed that uses up the room between them (Meeting), so
  // that the linearised step ends before they meet. Its force is linear in that speed. Against an
  // approach it takes energy. Where other stops slow the approach by more, it pulls.
  //
  // add_stops() finds the pairs that would meet on a path and makes stops for them, one for each
  // point at most: for the first to meet of the pairs in which the point has the largest weight,
  // and for the deepest of those that end in their barriers. More of them would mostly pull. Pairs
  // that still meet get theirs in a later call. If there are pairs that meet, stops that pull at
  // the `velocity` (m/s, by dynamic particle) of the end of the path are removed. `diagonal` has
  // the diagonal blocks (kg) of the matrix of the step, by dynamic particle: a stop is a hundred
  // times as stiff. Sets *added to the number of new stops. Returns a fault only if a position is
  // not finite.
  [[nodiscard]] std::optional<ContactFault> add_stops(const StepPath& path, double gamma,
                                                      std::span<const Vec3> velocity,
                                                      std::span<const Mat3> diagonal, int* added);
  // Adds the stops to pairs(), until the next evaluate(), and their forces (N) at the velocities of
  // the dynamic particles (m/s) to `force`. Replaces the stops of an earlier call.
  void apply_stops(std::span<const Vec3> velocity, std::span<Vec3> force);
  // Removes all stops, also from pairs().
  void clear_stops() {
    stops_.clear();
    surface_.remove_added_pairs();
  }
  bool has_stops() const { return !stops_.empty(); }
  // A step that is linearised about its start, and that has been solved.
  struct LinearStep {
    double gamma = 0;  // s
    // How the dynamic particles have moved (m) since the last evaluate(), and by how much their
    // velocities (m/s) have changed.
    std::span<const Vec3> displacement, change;
  };
  // Makes the friction of the last evaluate() obey Coulomb's law at the end of a step
  // (follow_step()), whose sliding velocities and pushes it has led to. Adds the change of the
  // friction forces (N) at the start of the step to `force`, by dynamic particle. Returns about by
  // how much (m/s) the change alters the fastest-altered sliding velocity at the end. O(pairs).
  double correct_friction(const LinearStep& step, std::span<Vec3> force);
  // Sets *smallest_gap to the smallest gap (m) of the candidates at `position`, or to infinity if
  // there are no candidates. The candidates include all pairs within their range. Returns a fault
  // if a gap is not positive, if two neighbours touch, or if a position is not finite.
  [[nodiscard]] std::optional<ContactFault> check_state(std::span<const Vec3> position,
                                                        double* smallest_gap);

 private:
  // Positions (m) and velocities (m/s) of the surface points at one time. Points of obstacles with
  // poses are valid only after PlacedPoints::place(). Both lists are empty if the points are the
  // particles. `start_` and `end_` have no velocities.
  struct Points {
    std::vector<Vec3> position, velocity;
  };
  // The particles on which the four points of a pair depend, each once, and the spins of its
  // spheres, whose weight is zero. The separation of the closest points is the sum of `weights`
  // times particle positions. With friction, the sliding velocity (Sliding) depends on the particle
  // velocities through `levers`; without friction, `levers` is empty.
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

  struct Stop {
    ContactPair pair;
    double allowed =
        0;  // slope of the distance from which on the stop acts (m/s); usually negative
  };
  std::optional<double> limit_at_end(const LinearStep& step,
                                     std::span<const ContactPair> terms) const;
  void add_friction_limit(const ContactPair& pair, double limit,
                          std::span<double> on_particle) const;
  double follow_step(const LinearStep& step, const ContactPair& pair, std::optional<double> part,
                     std::span<const double> limit_on_particle, std::span<Vec3> force);
  int heaviest_point(const ContactPair& pair) const;
  double closing_rate(const ContactPair& pair, std::span<const Vec3> velocity) const;
  double stop_damping(const ContactPair& pair, double gamma, std::span<const Mat3> diagonal) const;

  std::span<const Vec3> all_points(std::span<const Vec3> position) {
    return scene_.surface_map.points_of(position, scene_.point_count, now_.position);
  }
  PlacedPoints on_surface(const PlacedParticles& now, Points& points) const;
  void map_bodies(bool obstacles_too, std::span<const Vec3> from, std::vector<Vec3>& to) const;
  PointStray on_surface(const PathStray& stray);
  CurveStray curve_of(std::span<const Vec3> start, std::span<const Vec3> end, double covered);
  std::optional<ContactFault> check_curved(const PlacedParticles& start, const PlacedParticles& end,
                                           const PlacedPoints& from, const PlacedPoints& to,
                                           const PointStray& stray, const CurveStray& curve);
  std::optional<ContactFault> on_particles(std::optional<ContactFault> fault,
                                           std::span<const Vec3> position) const;
  template <class Use>
  void with_map(const Use& use) const;
  void add_forces_to(std::span<Vec3> normal, std::span<Vec3> friction) const;
  template <class Block>
  void add_pair_products(const Block& block, std::span<const Vec3> in, std::span<Vec3> out) const;
  template <class Slope>
  void add_sliding_products(double factor, const Slope& slope, std::span<const Vec3> in,
                            std::span<Vec3> out) const;
  Stencil stencil(const ContactPair& pair, StencilRoom& room) const;
  Stencil stencil_of_points(const ContactPair& pair, StencilRoom& room) const;
  Stencil joined_stencil(const ContactPair& pair, StencilRoom& room) const;
  bool is_dynamic(int particle) const { return particle < scene_.dynamic_particles; }
  static double normal_block(const ContactPair& pair, double gamma) {
    return gamma * (gamma * pair.stiffness + pair.damping);
  }
  // Returns D + gamma K of the friction of a pair, N s/m.
  static Mat3 slope_over(const Sliding& sliding, double gamma) {
    return sliding.slope + gamma * sliding.stiffness;
  }
  Mat3 definite_block(const ContactPair& pair, double gamma) const;

  const Scene& scene_;
  SurfaceContact surface_;
  Points now_, start_, end_;  // now_: at evaluations; start_, end_: at the ends of a path
  std::vector<Stop> stops_;
  std::vector<double> body_stray_, point_stray_;  // m, by body and by dynamic point
  std::vector<int> curved_bodies_;                // indices of the shells
  // m, by body: bound of the distance of a shell that is not dynamic from its triangles
  std::vector<double> held_deviation_;
  std::vector<double> body_curve_, point_curve_;  // m, by body and by dynamic point
  std::optional<CurvedPaths> curved_paths_;       // made when it is first needed
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
          const Sliding& sliding = surface_.sliding(pair.sliding);
          block += gamma * of.levers[i].transpose() * slope_over(sliding, gamma) * of.levers[j];
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
    const Stencil of = stencil_of_points(pair, room);
    visit(Coupling{of.particles, of.weights, definite_block(pair, gamma)});
    if (pair.sliding < 0 || pair.coefficient < 0) continue;
    const Sliding& sliding = surface_.sliding(pair.sliding);
    for (const SpinArm& spin : sliding.spins) {
      if (spin.point < 0) continue;
      const int particle = scene_.main_particle(spin.point);
      const Mat3 turn = cross_matrix(pair.normal);
      visit(Coupling{{&particle, 1},
                     {&spin.arm, 1},
                     gamma * turn.transpose() * slope_over(sliding, gamma) * turn});
    }
  }
}

}  // namespace weft::sim
