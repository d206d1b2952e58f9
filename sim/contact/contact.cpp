#include "sim/contact/contact.h"

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"
#include "sim/forces/stencil_array.h"
#include "sim/scene/spline_sampling.h"

namespace weft::sim {

namespace {

// Replaces SurfaceMap in loops if the points are the particles.
struct OwnParticles {
  static const Vec3& apply(int point, std::span<const Vec3> particles) { return particles[point]; }
  static void add_transpose(int point, double factor, const Vec3& value,
                            std::span<Vec3> particles) {
    particles[point] += factor * value;
  }
};

}  // namespace

Contact::Contact(const Scene& scene, Statistics& statistics, ChosenSearch search)
    : scene_(scene), surface_(scene, statistics, std::move(search)) {
  held_deviation_.assign(scene.bodies.size(), 0.0);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    if (!body.sampled || !body.spline) continue;
    curved_bodies_.push_back(static_cast<int>(b));
    if (body.dynamic) continue;
    held_deviation_[b] = deviation_from_samples(
        body.atlas, *body.spline,
        std::span(scene.initial_position).subspan(body.first_particle, body.particle_count()));
  }
}

// Calls use(map) with the scene's map. If the points are the particles, `map` is OwnParticles
// instead.
template <class Use>
void Contact::with_map(const Use& use) const {
  if (scene_.surface_map.is_identity()) {
    use(OwnParticles());
  } else {
    use(scene_.surface_map);
  }
}

// Maps positions of particles to positions of surface points, except on obstacles that have poses.
// PlacedPoints::place() computes points of these obstacles when they are needed.
PlacedPoints Contact::on_surface(const PlacedParticles& now, Points& points) const {
  const bool has_poses = !now.poses.empty();
  if (scene_.surface_map.is_identity())
    return has_poses ? PlacedPoints(now.room, now.velocity, now.poses, now.time)
                     : PlacedPoints(now.position, now.time);
  map_bodies(!has_poses, now.position, points.position);
  if (!has_poses) return {std::span<const Vec3>(points.position), now.time};
  return {points.position, points.velocity, now.poses, now.time};
}

// Computes the points of dynamic bodies and, if `obstacles_too`, of moving obstacles. The first
// call computes all points. Obstacles at rest keep these points in later calls.
void Contact::map_bodies(bool obstacles_too, std::span<const Vec3> from,
                         std::vector<Vec3>& to) const {
  const SurfaceMap& map = scene_.surface_map;
  if (to.empty()) {
    map.points_of(from, scene_.point_count, to);
    return;
  }
  parallel_chunks(scene_.dynamic_points, scene_.threads,
                  [&](int first, int last) { map.apply(from, to, first, last); });
  if (!obstacles_too) return;
  for (const RigidObstacle& obstacle : obstacles().all()) {
    const int first = obstacle.first_point;
    map.apply(from, to, first, first + scene_.bodies[obstacle.body].point_count());
  }
}

// Maps strays from particles to points. A point strays by at most the sum over its particles of the
// stray times the magnitude of the weight.
PointStray Contact::on_surface(const PathStray& stray) {
  if (scene_.surface_map.is_identity() || stray.body.empty()) return {stray.body, stray.particle};
  body_stray_.assign(scene_.bodies.size(), 0.0);
  point_stray_.assign(scene_.dynamic_points, 0.0);
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    if (stray.body[b] == 0) continue;
    const int first = scene_.bodies[b].first_point;
    for (int point = first; point < first + scene_.bodies[b].point_count(); ++point) {
      double sum = 0;
      for (const auto& [particle, weight] : scene_.surface_map.shares(point))
        sum += std::abs(weight) * (is_dynamic(particle) ? stray.particle[particle] : stray.body[b]);
      body_stray_[b] = std::max(body_stray_[b], sum);
      if (point < scene_.dynamic_points) point_stray_[point] = sum;
    }
  }
  return {body_stray_, point_stray_};
}

// Returns how far curved surfaces leave their triangles on the straight paths start -> end. Second
// derivatives are linear functions of the control points, so the bound of a surface on the way is
// no larger than at one of the ends.
CurveStray Contact::curve_of(std::span<const Vec3> start, std::span<const Vec3> end,
                             double covered) {
  if (curved_bodies_.empty()) return {};
  body_curve_.assign(scene_.bodies.size(), 0.0);
  point_curve_.assign(scene_.dynamic_points, 0.0);
  bool is_covered = true;
  for (const int b : curved_bodies_) {
    const SceneBody& body = scene_.bodies[b];
    const double by_thickness = covered * body.thickness;
    body_curve_[b] = std::max(held_deviation_[b] - by_thickness, 0.0);
    if (body.dynamic) {
      const auto points = std::span(point_curve_).subspan(body.first_point, body.point_count());
      for (const auto& x : {start, end}) {
        raise_to_deviations(body.atlas, *body.spline, body.sampled->atlas,
                            x.subspan(body.first_particle, body.particle_count()), points);
      }
      for (double& each : points) {
        each = std::max(each - by_thickness, 0.0);
        body_curve_[b] = std::max(body_curve_[b], each);
      }
    }
    is_covered &= body_curve_[b] == 0;
  }
  if (is_covered) return {};
  return {{body_curve_, point_curve_}, covered};
}

// In a fault of kind not_finite, replaces the surface point by the particle that causes it.
std::optional<ContactFault> Contact::on_particles(std::optional<ContactFault> fault,
                                                  std::span<const Vec3> position) const {
  if (!fault || fault->kind != ContactFault::Kind::not_finite || scene_.surface_map.is_identity())
    return fault;
  const auto shares = scene_.surface_map.shares(fault->nodes[0]);
  const auto distance = [&](const SurfaceMap::Share& share) {
    const double square = position[share.particle].squaredNorm();
    return std::isnan(square) ? INFINITY : square;
  };
  fault->nodes[0] = std::ranges::max(shares, {}, distance).particle;
  return fault;
}

std::optional<ContactFault> Contact::evaluate(const PlacedParticles& now,
                                              std::span<const Vec3> velocity, int threads) {
  if (scene_.surface_map.is_identity())
    return surface_.evaluate(on_surface(now, now_), velocity, threads);
  map_bodies(now.poses.empty(), velocity, now_.velocity);
  return on_particles(surface_.evaluate(on_surface(now, now_), now_.velocity, threads),
                      now.position);
}

void Contact::add_forces(std::span<Vec3> force) const { add_forces_to(force, force); }

void Contact::add_forces(std::span<Vec3> normal, std::span<Vec3> friction) const {
  add_forces_to(normal, friction);
}

// Adds contact forces to two lists, which may be the same list.
void Contact::add_forces_to(std::span<Vec3> normal, std::span<Vec3> friction) const {
  const bool all = static_cast<int>(normal.size()) > scene_.dynamic_particles;
  const int count = all ? scene_.point_count : scene_.dynamic_points;
  with_map([&](const auto& map) {
    for (const ContactPair& pair : surface_.pairs()) {
      const Vec3 push = pair.push * pair.normal;
      for (int i = 0; i < 4; ++i) {
        if (pair.nodes[i] < count) map.add_transpose(pair.nodes[i], pair.weight[i], push, normal);
      }
      if (pair.sliding < 0) continue;
      const Sliding& sliding = surface_.sliding(pair.sliding);
      for (int i = 0; i < 4; ++i) {
        if (pair.nodes[i] < count)
          map.add_transpose(pair.nodes[i], 1, sliding.lever[i].transpose() * sliding.force,
                            friction);
      }
      for (const SpinArm& spin : sliding.spins) {
        if (spin.point >= 0)
          map.add_transpose(spin.point, spin.arm, sliding.force.cross(pair.normal), friction);
      }
    }
    for (const MollifierForce& mollified : surface_.mollified()) {
      for (int i = 0; i < 4; ++i) {
        if (mollified.nodes[i] < count)
          map.add_transpose(mollified.nodes[i], 1, mollified.force[i], normal);
      }
    }
  });
}

// Forces and moments are taken at the dynamic points, because friction acts on an obstacle at these
// points (Sliding).
void Contact::add_wrenches(std::span<const Vec3> position, std::span<Wrench> by_body) const {
  const auto wrench_of = [&](const std::array<int, 4>& nodes) -> Wrench* {
    const int highest = std::max(nodes[0], nodes[3]);
    return highest < scene_.dynamic_points ? nullptr
                                           : &by_body[scene_.body_index_of_point(highest)];
  };
  with_map([&](const auto& map) {
    const auto add = [&](Wrench& wrench, int point, const Vec3& force) {
      if (point < scene_.dynamic_points) wrench.add(map.apply(point, position), force);
    };
    for (const ContactPair& pair : surface_.pairs()) {
      Wrench* const wrench = wrench_of(pair.nodes);
      if (wrench == nullptr) continue;
      const Sliding* const sliding = pair.sliding < 0 ? nullptr : &surface_.sliding(pair.sliding);
      for (int i = 0; i < 4; ++i) {
        add(*wrench, pair.nodes[i], pair.weight[i] * pair.push * pair.normal);
        if (sliding != nullptr)
          add(*wrench, pair.nodes[i], sliding->lever[i].transpose() * sliding->force);
      }
      for (int k = 0; sliding != nullptr && k < 2; ++k) {
        const SpinArm& spin = sliding->spins[k];
        if (spin.point < 0) continue;
        const double radius = scene_.bodies[scene_.body_index_of_point(spin.point)].spheres->radius;
        wrench->moment += radius * spin.arm * sliding->force.cross(pair.normal);
      }
    }
    for (const MollifierForce& mollified : surface_.mollified()) {
      Wrench* const wrench = wrench_of(mollified.nodes);
      for (int i = 0; wrench != nullptr && i < 4; ++i)
        add(*wrench, mollified.nodes[i], mollified.force[i]);
    }
  });
}

void Contact::find_loaded_obstacles(std::vector<int>& particles) const {
  particles.clear();
  const auto add = [&](const std::array<int, 4>& nodes) {
    for (const int node : nodes) {
      if (node < scene_.dynamic_points) continue;
      if (scene_.surface_map.is_identity()) {
        particles.push_back(node);
      } else {
        for (const auto& share : scene_.surface_map.shares(node))
          particles.push_back(share.particle);
      }
    }
  };
  for (const ContactPair& pair : surface_.pairs()) add(pair.nodes);
  for (const MollifierForce& mollified : surface_.mollified()) add(mollified.nodes);
  std::sort(particles.begin(), particles.end());
  particles.erase(std::unique(particles.begin(), particles.end()), particles.end());
}

void Contact::mark_particles_in_reach(std::vector<char>& marks) const {
  marks.assign(scene_.dynamic_particles, 0);
  for (const ContactPair& pair : surface_.pairs()) {
    for (const int node : pair.nodes) {
      if (node >= scene_.dynamic_points) continue;
      if (scene_.surface_map.is_identity()) {
        marks[node] = 1;
      } else {
        for (const auto& share : scene_.surface_map.shares(node)) {
          if (is_dynamic(share.particle)) marks[share.particle] = 1;
        }
      }
    }
    if (pair.sliding < 0) continue;
    for (const SpinArm& spin : surface_.sliding(pair.sliding).spins)
      if (spin.point >= 0) marks[scene_.main_particle(spin.point)] = 1;
  }
}

double Contact::energy() const {
  double sum = 0;
  for (const ContactPair& pair : surface_.pairs()) sum += pair.energy;
  return sum;
}

// For each pair with normal n, adds weight_i block(pair) n (n . sum_j weight_j in_j) to out_i. The
// indices i and j number the four points of the pair. Points that are not dynamic are left out.
template <class Block>
void Contact::add_pair_products(const Block& block, std::span<const Vec3> in,
                                std::span<Vec3> out) const {
  const int count = scene_.dynamic_points;
  with_map([&](const auto& map) {
    for (const ContactPair& pair : surface_.pairs()) {
      Vec3 sum = Vec3::Zero();
      for (int i = 0; i < 4; ++i) {
        if (pair.nodes[i] < count) sum += pair.weight[i] * map.apply(pair.nodes[i], in);
      }
      const Vec3 product = block(pair) * pair.normal.dot(sum) * pair.normal;
      for (int i = 0; i < 4; ++i) {
        if (pair.nodes[i] < count) map.add_transpose(pair.nodes[i], pair.weight[i], product, out);
      }
    }
  });
}

// For each pair with friction, adds factor lever_i^T slope(sliding) (sum_j lever_j in_j) to out_i.
template <class Slope>
void Contact::add_sliding_products(double factor, const Slope& slope, std::span<const Vec3> in,
                                   std::span<Vec3> out) const {
  if (!surface_.has_sliding()) return;
  const int count = scene_.dynamic_points;
  with_map([&](const auto& map) {
    for (const ContactPair& pair : surface_.pairs()) {
      if (pair.sliding < 0) continue;
      const Sliding& sliding = surface_.sliding(pair.sliding);
      Vec3 sum = Vec3::Zero();
      for (int i = 0; i < 4; ++i) {
        if (pair.nodes[i] < count) sum += sliding.lever[i] * map.apply(pair.nodes[i], in);
      }
      for (const SpinArm& spin : sliding.spins)
        if (spin.point >= 0) sum += spin.arm * pair.normal.cross(map.apply(spin.point, in));
      const Vec3 product = factor * (slope(sliding) * sum);
      for (const SpinArm& spin : sliding.spins) {
        if (spin.point >= 0)
          map.add_transpose(spin.point, spin.arm, product.cross(pair.normal), out);
      }
      for (int i = 0; i < 4; ++i) {
        if (pair.nodes[i] < count)
          map.add_transpose(pair.nodes[i], 1, sliding.lever[i].transpose() * product, out);
      }
    }
  });
}

// Without flattening, the compiler calls a function for each sum of two vectors.
WEFT_FLATTEN void Contact::add_product(double gamma, std::span<const Vec3> in,
                                       std::span<Vec3> out) const {
  add_pair_products([&](const ContactPair& pair) { return normal_block(pair, gamma); }, in, out);
  add_sliding_products(
      gamma, [&](const Sliding& of) { return slope_over(of, gamma); }, in, out);
}

void Contact::subtract_stiffness(double factor, std::span<const Vec3> in,
                                 std::span<Vec3> out) const {
  add_pair_products([&](const ContactPair& pair) { return -factor * pair.stiffness; }, in, out);
  if (surface_.has_anchors())
    add_sliding_products(
        -factor, [](const Sliding& of) { return of.stiffness; }, in, out);
}

Contact::Stencil Contact::stencil(const ContactPair& pair, StencilRoom& room) const {
  const Stencil points = stencil_of_points(pair, room);
  if (pair.sliding < 0 || !surface_.sliding(pair.sliding).has_spins()) return points;
  StencilRoom all{{points.particles.begin(), points.particles.end()},
                  {points.weights.begin(), points.weights.end()},
                  {points.levers.begin(), points.levers.end()}};
  for (const SpinArm& spin : surface_.sliding(pair.sliding).spins) {
    if (spin.point < 0) continue;
    all.particles.push_back(scene_.main_particle(spin.point));
    all.weights.push_back(0);
    all.levers.emplace_back(spin.arm * cross_matrix(pair.normal));
  }
  room = std::move(all);
  return {room.particles, room.weights, room.levers};
}

Contact::Stencil Contact::stencil_of_points(const ContactPair& pair, StencilRoom& room) const {
  if (!scene_.surface_map.is_identity()) return joined_stencil(pair, room);
  // A sphere has all its weight on the first of three equal nodes.
  const std::size_t count = pair.nodes[1] == pair.nodes[2] ? 2 : 4;
  const auto particles = std::span(pair.nodes).first(count);
  const auto weights = std::span(pair.weight).first(count);
  if (pair.sliding < 0) return {particles, weights, {}};
  return {particles, weights, std::span(surface_.sliding(pair.sliding).lever).first(count)};
}

// Sums the weights and levers of a pair's four points by particle.
Contact::Stencil Contact::joined_stencil(const ContactPair& pair, StencilRoom& room) const {
  const Sliding* const sliding = pair.sliding < 0 ? nullptr : &surface_.sliding(pair.sliding);
  room = {};
  for (int i = 0; i < 4; ++i) {
    for (const auto& [particle, weight] : scene_.surface_map.shares(pair.nodes[i])) {
      const auto place = std::ranges::find(room.particles, particle) - room.particles.begin();
      if (place == std::ssize(room.particles)) {
        room.particles.push_back(particle);
        room.weights.push_back(0);
        if (sliding != nullptr) room.levers.emplace_back(Mat3::Zero());
      }
      room.weights[place] += weight * pair.weight[i];
      if (sliding != nullptr) room.levers[place] += weight * sliding->lever[i];
    }
  }
  return {room.particles, room.weights, room.levers};
}

WEFT_FLATTEN std::vector<int> Contact::add_diagonal(double gamma, std::span<Mat3> diagonal) const {
  std::vector<int> touched;
  StencilRoom room;
  for (const ContactPair& pair : surface_.pairs()) {
    const Mat3 along = normal_block(pair, gamma) * pair.normal * pair.normal.transpose();
    const Stencil of = stencil(pair, room);
    for (std::size_t i = 0; i < of.particles.size(); ++i) {
      if (!is_dynamic(of.particles[i])) continue;
      touched.push_back(of.particles[i]);
      Mat3& block = diagonal[of.particles[i]];
      block += of.weights[i] * of.weights[i] * along;
      if (pair.sliding < 0) continue;
      const Sliding& sliding = surface_.sliding(pair.sliding);
      block += gamma * of.levers[i].transpose() * slope_over(sliding, gamma) * of.levers[i];
    }
  }
  return touched;
}

Mat3 Contact::definite_block(const ContactPair& pair, double gamma) const {
  Mat3 block = std::max(normal_block(pair, gamma), 0.0) * pair.normal * pair.normal.transpose();
  if (pair.sliding < 0 || pair.coefficient < 0) return block;
  const Sliding& sliding = surface_.sliding(pair.sliding);
  return block + gamma * slope_over(sliding, gamma);
}

double Contact::largest_relative_gap_change(std::span<const Vec3> start, std::span<const Vec3> from,
                                            std::span<const Vec3> to, double closing_factor) const {
  double largest = 0;
  with_map([&](const auto& map) {
    const auto change_of = [&](const ContactPair& pair, std::span<const Vec3> before,
                               std::span<const Vec3> after) {
      double change = 0;
      for (int i = 0; i < 4; ++i) {
        const int node = pair.nodes[i];
        if (node < scene_.dynamic_points)
          change +=
              pair.weight[i] * pair.normal.dot(map.apply(node, after) - map.apply(node, before));
      }
      return change;
    };
    for (const ContactPair& pair : surface_.pairs()) {
      const bool has_closed = change_of(pair, start, from) < -pair.gap;
      const double change = std::abs(change_of(pair, from, to)) * (has_closed ? closing_factor : 1);
      largest = std::max(largest, change / pair.gap);
    }
  });
  return largest;
}

std::optional<double> Contact::smallest_gap() const {
  if (surface_.pairs().empty()) return std::nullopt;
  return std::ranges::min(surface_.pairs(), {}, &ContactPair::gap).gap;
}

std::optional<ContactFault> Contact::check_path(const PlacedParticles& start,
                                                const PlacedParticles& end,
                                                const PathStray& stray) {
  const PlacedPoints from = on_surface(start, start_), to = on_surface(end, end_);
  // Half the mean of two thicknesses keeps features apart on their paths: a quarter of either.
  const CurveStray curve = curve_of(start.position, end.position, 0.25);
  const PointStray strays = on_surface(stray);
  auto fault = on_particles(surface_.check_path(from, to, strays, curve), end.position);
  return fault ? fault : check_curved(start, end, from, to, strays, curve);
}

// Checks the pairs that the last check of triangles left open.
std::optional<ContactFault> Contact::check_curved(const PlacedParticles& start,
                                                  const PlacedParticles& end,
                                                  const PlacedPoints& from, const PlacedPoints& to,
                                                  const PointStray& stray,
                                                  const CurveStray& curve) {
  if (surface_.open().empty()) return std::nullopt;
  if (!curved_paths_) curved_paths_.emplace(scene_);
  return curved_paths_->find_fault(surface_.open(), {start.position, end.position, from, to}, stray,
                                   curve, obstacles());
}

std::optional<ContactFault> Contact::check_crossing(const PlacedParticles& start,
                                                    const PlacedParticles& end) {
  const PlacedPoints from = on_surface(start, start_), to = on_surface(end, end_);
  const CurveStray curve = curve_of(start.position, end.position, 0);
  auto fault = on_particles(surface_.check_crossing(from, to, curve), end.position);
  return fault ? fault : check_curved(start, end, from, to, {}, curve);
}

std::optional<ContactFault> Contact::check_state(std::span<const Vec3> position,
                                                 double* smallest_gap) {
  return on_particles(surface_.check_state(all_points(position), smallest_gap), position);
}

}  // namespace weft::sim
