#include "sim/contact/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "materials/contact.h"
#include "sim/base/parallel.h"
#include "sim/case/case_text.h"
#include "sim/contact/contact_stiffness.h"
#include "sim/contact/surface_features.h"

namespace weft::sim {

namespace {

// Returns the smallest index from `i` on at which a chunk of pairs may begin. For samples, all
// pairs of a vertex belong to one chunk.
std::size_t group_start(std::span<const bsi::FourParticles> nodes, bool samples, std::size_t i) {
  while (samples && i > 0 && i < nodes.size() && nodes[i][0] == nodes[i - 1][0]) ++i;
  return i;
}

// Returns the secant of friction, the force divided by the sliding speed, N s/m. Across the sliding
// velocity, the slope is the secant already. Precondition: the force is not zero.
double secant_of(const Vec3& normal, const Sliding& sliding) {
  const Vec3 across = normal.cross(sliding.force).normalized();
  return across.dot(sliding.slope * across);
}

// Replaces the slope of friction by its secant. The slope of full friction is zero along the
// sliding velocity. A single correction would then apply the whole friction of the start of a long
// step, whatever is left of the sliding at its end, and throw light vertices back. With the secant,
// friction at most ends the sliding.
//
// An anchor takes the secant for its stiffness, too.
void use_secant(const Vec3& normal, double hold_rate, Sliding& sliding) {
  if (sliding.force.isZero(0)) return;
  sliding.slope = secant_of(normal, sliding) * (Mat3::Identity() - normal * normal.transpose());
  if (!sliding.stiffness.isZero(0)) sliding.stiffness = hold_rate * sliding.slope;
}

// Returns true if the sliding velocity, which is -force / secant, has turned by more than a right
// angle when it changed by `change`.
bool has_turned_back(const Vec3& normal, const Vec3& change, const Sliding& sliding) {
  const double squared = sliding.force.squaredNorm();
  return squared > 0 && squared + secant_of(normal, sliding) * sliding.force.dot(change) < 0;
}

}  // namespace

std::string ContactFault::describe(const Scene& scene) const {
  const auto name = [&](int point) { return scene.describe_point(point); };
  switch (kind) {
    case Kind::not_finite:
      return "the position of " + scene.describe_particle(nodes[0]) +
             " is not finite, or more than 1e15 m from the origin";
    case Kind::touching:
      return "no gap is left between the features at " + name(nodes[0]) + " and " + name(nodes[3]) +
             " (gap " + rounded_text(gap) + " m)";
    case Kind::pressed:
      return "the surfaces at " + name(nodes[0]) + " and " + name(nodes[3]) +
             " are pressed together (gap " + rounded_text(gap) + " m)";
    case Kind::curved:
      return "the curved surfaces at " + name(nodes[0]) + " and " + name(nodes[3]) +
             " may pass through each other: between the points on which contact acts they may "
             "leave "
             "their triangles by " +
             rounded_text(gap) +
             " m, and these are not kept farther apart (a finer image, or a larger thickness of "
             "the "
             "body, covers more)";
    case Kind::crossing:
      return "the features at " + name(nodes[0]) + " and " + name(nodes[3]) +
             " would pass through each other";
    case Kind::overstretched:
      return "the membrane would exceed its strain_limit at " + scene.describe_particle(nodes[0]);
  }
  return "";
}

int ContactFault::particle(const Scene& scene) const {
  const bool is_particle = kind == Kind::not_finite || kind == Kind::overstretched;
  return is_particle ? nodes[0] : scene.main_particle(nodes[0]);
}

SurfaceContact::SurfaceContact(const Scene& scene, Statistics& statistics, ChosenSearch search)
    : scene_(scene),
      statistics_(statistics),
      search_(scene, statistics, std::move(search)),
      range_(scene.source.contact.range),
      damping_time_(scene.source.contact.damping_time),
      friction_speed_(scene.source.contact.friction_speed),
      hold_rate_(friction_speed_ / scene.source.contact.sticking_distance.value_or(1)),
      friction_(scene),
      spheres_(scene),
      obstacle_spins_(scene.bodies.size(), Vec3::Zero()),
      touched_(scene.bodies.size(), 0) {
  surfaces_.reserve(scene.bodies.size());
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    const std::vector<Vec3>& rest = body.surface_rest();
    rest_.insert(rest_.end(), rest.begin(), rest.end());
    case_index_.push_back(scene.case_index(static_cast<int>(b)));
    surfaces_.emplace_back(body.surface_mesh(), body.point_count(),
                           search_.neighbourhoods(static_cast<int>(b)));
  }
  for (std::size_t b = scene.dynamic_bodies; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].moves) moving_obstacles_.push_back(static_cast<int>(b));
  }
  // The timed choice of `auto` must not change a bit of a trajectory, so that the device evaluates
  // only where the case asks for it. On the device, all points must be in place, sleeping bodies
  // are not touched, there are neither spheres nor anchors, and nothing looks ahead in a step or
  // changes friction in it.
  const bool is_possible = scene.source.compute.backend == ComputeBackend::gpu &&
                           search_.obstacles().all().empty() && scene.source.time.newton == 0 &&
                           !scene.source.contact.sticking_distance &&
                           std::ranges::none_of(scene.bodies, [](const SceneBody& body) {
                             return body.sleeps || body.spheres != nullptr;
                           });
  if (is_possible) device_ = search_.make_device_contact();
}

double SurfaceContact::range_of(const PairGroup& group) const {
  const bool on_cloth =
      group.of_spheres && !group.on_spheres && scene_.bodies[group.surface].dynamic;
  return group.samples && !on_cloth ? range_ : short_range * range_;
}

ContactLaw SurfaceContact::law_of(const PairGroup& group, const std::array<int, 4>& nodes) const {
  const double range = range_of(group);
  if (group.of_spheres) return spheres_.of(group.body_a, group.body_b, range);
  ContactLaw law{range, 0, damping_time_, group.friction, friction_speed_};
  if (!group.samples) {
    law.stiffness = pair_stiffness(scene_, nodes, group.edges);
  } else if (group.on_spheres) {
    // Spheres have no samples, so that those of the other side count in full.
    law.stiffness = scene_.source.contact.stiffness * scene_.contact_area[nodes[0]];
  } else {
    law.stiffness = sample_stiffness(scene_, scene_.bodies[group.surface], nodes[0]);
  }
  // Points of cloth stay where they hit a sphere: a restitution of 0.
  if (group.on_spheres)
    law.settling_speed = spheres_.of(group.body_a, group.body_b, range).settling_speed;
  return law;
}

void SurfaceContact::begin_placing() {
  const std::size_t obstacles = search_.obstacles().all().size();
  if (obstacles > 0) marks_.begin(scene_.point_count + static_cast<int>(obstacles));
}

// Computes the positions of a group's points on an obstacle that is given by its pose. Each point
// is computed once after begin_placing(). If the obstacle has few points, all of them are computed,
// which costs less than checking every node of the group.
void SurfaceContact::place_nodes(const PairGroup& group, const PlacedPoints& start,
                                 const PlacedPoints& end) {
  const int number = search_.obstacles().of_body(group.body_b);
  if (end.pose(number) == nullptr) return;
  const RigidObstacle& obstacle = search_.obstacles().all()[number];
  if (obstacle.start().size() <= group.nodes.size()) {
    if (!marks_.is_new(scene_.point_count + number)) return;
    end.place_all(obstacle);
    if (!start.is_same(end)) start.place_all(obstacle);
    return;
  }
  for (const bsi::FourParticles& nodes : group.nodes) {
    for (const int node : nodes) {
      if (node < obstacle.first_point || !marks_.is_new(node)) continue;
      end.place(obstacle, node);
      if (!start.is_same(end)) start.place(obstacle, node);
    }
  }
}

std::optional<ContactFault> SurfaceContact::evaluate(const PlacedPoints& now,
                                                     std::span<const Vec3> velocity, int threads) {
  clear();
  if (const auto bad = search_.update(now, velocity))
    return ContactFault{ContactFault::Kind::not_finite, {*bad}};
  PhaseTimer timer(statistics_.phases.narrow_phase);
  const std::span<const Vec3> position = measured_at_ = now.position();
  if (friction_.any()) find_spins(now, velocity);
  if (uses_device()) {
    try {
      return evaluate_on_device(now, velocity);
    } catch (const std::runtime_error& error) {
      search_.note_failure(error.what());
      device_.reset();
      clear();
    }
  }
  begin_placing();
  if (has_anchors()) place_anchors(now);
  for (const PairGroup* each : groups_within(range_, short_range * range_, in_range_)) {
    const PairGroup& group = *each;
    place_nodes(group, now, now);
    note_touch(group, position);
    const int count = static_cast<int>(group.nodes.size());
    statistics_.counters.narrow_phase_calls += count;
    // Each chunk collects its own results. They are joined in the order of the chunks, so that sums
    // do not depend on the number of threads.
    const auto measure = [&](int first, int last, Found& part) {
      part.clear();
      measure_part(group, group_start(group.nodes, group.samples, first),
                   group_start(group.nodes, group.samples, last), position, velocity, part);
    };
    for (Found& part : parallel_parts(found_, count, threads, measure)) {
      if (part.fault) {
        clear();
        return part.fault;
      }
      join(part);
    }
  }
  statistics_.counters.friction_terms += static_cast<std::int64_t>(sliding_.size());
  use_secants_past_rest(velocity);
  return std::nullopt;
}

// Returns true if there is a device, which is likely to be faster than the CPU.
bool SurfaceContact::uses_device() const {
  if (device_ == nullptr) return false;
  std::size_t candidates = 0;
  for (const CandidateList& list : search_.lists()) candidates += list.candidate_count();
  return candidates >= least_candidates_for_device;
}

std::optional<ContactFault> SurfaceContact::evaluate_on_device(const PlacedPoints& now,
                                                               std::span<const Vec3> velocity) {
  if (on_device_ != search_.changes()) {
    device_->set_candidates(search_.lists(), surfaces_, rest_);
    on_device_ = search_.changes();
  }
  DeviceContact::Found found{std::move(pairs_), std::move(sliding_), std::move(mollified_)};
  const auto touching = device_->evaluate(search_.lists(), friction_,
                                          {now.position(), velocity, obstacle_spins_}, found);
  pairs_ = std::move(found.pairs);
  sliding_ = std::move(found.sliding);
  mollified_ = std::move(found.mollified);
  for (const CandidateList& list : search_.lists())
    statistics_.counters.narrow_phase_calls += static_cast<std::int64_t>(list.candidate_count());
  if (touching) {
    clear();
    const bsi::Closest closest = closest_of(touching->edges, touching->nodes, now.position());
    return ContactFault{ContactFault::Kind::touching, touching->nodes,
                        std::sqrt(closest.squared_distance) - touching->thickness};
  }
  if (definite_) {
    for (ContactPair& pair : pairs_) {
      make_definite(pair);
      if (pair.sliding >= 0) make_definite(pair, sliding_[pair.sliding]);
    }
  }
  statistics_.counters.friction_terms += static_cast<std::int64_t>(sliding_.size());
  use_secants_past_rest(velocity);
  return std::nullopt;
}

// Marks the sleeping body of a group if it is touched. Only the second body of a group can sleep,
// because sleeping bodies have higher indices than dynamic bodies.
void SurfaceContact::note_touch(const PairGroup& group, std::span<const Vec3> position) {
  if (!scene_.bodies[group.body_b].sleeps || touched_[group.body_b] != 0) return;
  const double reach = group.thickness + range_;
  const bool touches = std::ranges::any_of(group.nodes, [&](const bsi::FourParticles& nodes) {
    return closest_of(group.edges, nodes, position).squared_distance < reach * reach;
  });
  if (touches) touched_[group.body_b] = 1;
}

// Finds the angular velocities of moving obstacles. Obstacles are rigid, so one triangle of each
// suffices.
void SurfaceContact::find_spins(const PlacedPoints& now, std::span<const Vec3> velocity) {
  for (const int b : moving_obstacles_) {
    const SceneBody& body = scene_.bodies[b];
    std::array<Vec3, 3> x, v;
    for (int k = 0; k < 3; ++k) {
      const int point = body.surface_mesh().triangles[0][k] + body.first_point;
      const int number = search_.obstacles().of_body(b);
      if (now.pose(number) != nullptr) now.place(search_.obstacles().all()[number], point);
      x[k] = now.position()[point];
      v[k] = velocity[point];
    }
    obstacle_spins_[b] = rigid_spin(x, v);
  }
}

// Returns the angular velocity (rad/s) of the obstacle of a pair, if one feature belongs to an
// obstacle.
std::optional<Vec3> SurfaceContact::obstacle_spin(const std::array<int, 4>& nodes) const {
  for (const int node : {nodes[0], nodes[3]}) {
    if (!is_dynamic(node)) return obstacle_spins_[scene_.body_index_of_point(node)];
  }
  return std::nullopt;
}

void SurfaceContact::clear() {
  pairs_.clear();
  added_pairs_ = 0;
  sliding_.clear();
  mollified_.clear();
}

void SurfaceContact::join(Found& part) {
  const int offset = static_cast<int>(sliding_.size());
  for (ContactPair& pair : part.pairs) {
    if (pair.sliding >= 0) pair.sliding += offset;
    pairs_.push_back(pair);
  }
  sliding_.insert(sliding_.end(), part.sliding.begin(), part.sliding.end());
  mollified_.insert(mollified_.end(), part.mollified.begin(), part.mollified.end());
}

void SurfaceContact::measure_part(const PairGroup& group, std::size_t first, std::size_t last,
                                  std::span<const Vec3> position, std::span<const Vec3> velocity,
                                  Found& found) const {
  std::vector<bsi::PairInReach>& in_reach = found.in_reach;
  bsi::find_in_reach(group.kind(), position, std::span(group.nodes).subspan(first, last - first),
                     group.thickness + range_of(group), in_reach);
  std::size_t begin = 0;
  while (begin < in_reach.size() && !found.fault) {
    std::size_t end = begin + 1;
    if (!group.samples || group.on_spheres) {
      measure_pair(group, first + in_reach[begin].pair, position, velocity, found);
    } else {
      const auto vertex = [&](std::size_t i) { return group.nodes[first + in_reach[i].pair][0]; };
      while (end < in_reach.size() && vertex(end) == vertex(begin)) ++end;
      measure_sample(group, first, std::span(in_reach).subspan(begin, end - begin), position,
                     velocity, found);
    }
    begin = end;
  }
}

// Measures one sample with the triangles of a surface that are in its range.
void SurfaceContact::measure_sample(const PairGroup& group, std::size_t first,
                                    std::span<const bsi::PairInReach> in_reach,
                                    std::span<const Vec3> position, std::span<const Vec3> velocity,
                                    Found& found) const {
  SampleScratch& scratch = found.scratch;
  const SceneBody& body = scene_.bodies[group.surface];
  const int vertex = group.nodes[first + in_reach[0].pair][0];
  scratch.triangles.clear();
  for (const bsi::PairInReach& near : in_reach) {
    scratch.triangles.push_back(group.triangles[first + near.pair]);
    const double gap = near.distance - group.thickness;
    if (gap > 0) continue;
    found.fault = ContactFault{ContactFault::Kind::touching, group.nodes[first + near.pair], gap};
    return;
  }
  const int own = group.is_self() || group.across != nullptr
                      ? vertex - scene_.bodies[group.body_of_first()].first_point
                      : -1;
  surfaces_[group.surface].find(position[vertex], own, scratch.triangles,
                                position.subspan(body.first_point, body.point_count()),
                                group.thickness + range_of(group), scratch.terms, group.across);
  const Anchor* const anchor =
      has_anchors() ? find_anchor(anchors_->selected(),
                                  anchor_key(vertex, group.body_of_first(), group.surface))
                    : nullptr;
  Vec3 offset = Vec3::Zero(), lead = Vec3::Zero();
  if (anchor != nullptr) offset = from_anchor(*anchor, position);
  if (anchor != nullptr && step_ahead() > 0) {
    const AnchorRates rates = rates_of(*anchor, velocity);
    lead = step_ahead() * rates.free;
    offset += lead + step_ahead() * rates.obstacles;
  }
  PairLaw of{.law = law_of(group, group.nodes[first + in_reach[0].pair]),
             .of_spheres = group.of_spheres ? &group : nullptr,
             .surface = group.surface,
             .from_anchor = anchor == nullptr ? nullptr : &offset,
             .lead = lead};
  of.law.hold_rate = hold_rate_;
  for (const bsi::SurfaceTerm& term : scratch.terms) {
    Pair features{{vertex, 0, 0, 0}, false, group.thickness};
    for (int k = 0; k < 3; ++k)
      features.nodes[k + 1] = body.surface_mesh().triangles[term.triangle][k] + body.first_point;
    of.coefficient = term.coefficient;
    add_pair(of, features, term.closest, position, velocity, found);
  }
}

// Measures a pair that is no term of a sum: two edges, an obstacle's vertex and a triangle, or a
// point and a sphere.
void SurfaceContact::measure_pair(const PairGroup& group, std::size_t number,
                                  std::span<const Vec3> position, std::span<const Vec3> velocity,
                                  Found& found) const {
  const Pair pair = group.pair(number);
  const bsi::Closest closest = closest_of(pair.edges, pair.nodes, position);
  const double limit = pair.thickness + range_of(group);
  if (closest.squared_distance >= limit * limit) return;
  PairLaw of{.law = law_of(group, pair.nodes),
             .of_spheres = group.has_spheres() ? &group : nullptr};
  if (pair.edges) of.mollifier = mollify(pair, closest, position, of.law, found);
  add_pair(of, pair, closest, position, velocity, found);
}

// Returns by how much (m) the obstacle of a pair changes its distance in the step ahead.
double SurfaceContact::change_by_obstacle(const std::array<int, 4>& nodes,
                                          const bsi::Closest& closest,
                                          std::span<const Vec3> velocity) const {
  Vec3 rate = Vec3::Zero();
  for (int i = 0; i < 4; ++i) {
    if (!is_dynamic(nodes[i])) rate += closest.weight[i] * velocity[nodes[i]];
  }
  return step_ahead() * closest.separation.normalized().dot(rate);
}

void SurfaceContact::add_pair(const PairLaw& of, const Pair& features, const bsi::Closest& closest,
                              std::span<const Vec3> position, std::span<const Vec3> velocity,
                              Found& found) const {
  const ContactLaw& law = of.law;
  const double gap = std::sqrt(closest.squared_distance) - features.thickness;
  if (!(gap > 0)) {
    found.fault = ContactFault{ContactFault::Kind::touching, features.nodes, gap};
    return;
  }
  ContactPair pair;
  pair.nodes = features.nodes;
  pair.coefficient = of.coefficient;
  pair.surface = of.surface;
  const double barrier_push =
      apply_push(law, features.thickness, of.mollifier, closest, velocity, pair);
  if (definite_) make_definite(pair);
  const double change = step_ahead() > 0 ? change_by_obstacle(pair.nodes, closest, velocity) : 0;
  pair.push -= pair.stiffness * change;
  if (law.friction > 0) {
    const bsi::FourPoints points{position[pair.nodes[0]], position[pair.nodes[1]],
                                 position[pair.nodes[2]], position[pair.nodes[3]]};
    const auto kind =
        features.edges ? bsi::FeatureKind::edge_edge : bsi::FeatureKind::vertex_triangle;
    SlidingFeatures sliding_features{kind, closest, points, velocity};
    sliding_features.from_anchor = of.from_anchor;
    if (const PairGroup* const group = of.of_spheres) {
      sliding_features.obstacle_spin = Vec3::Zero();
      sliding_features.spins =
          spheres_.spins(group->body_of_first(), group->surface, pair.nodes, closest);
    } else {
      sliding_features.obstacle_spin = obstacle_spin(pair.nodes);
    }
    auto sliding = friction_of(law, barrier_push, sliding_features, pair);
    if (sliding) {
      if (definite_) make_definite(pair, *sliding);
      sliding->limit.expected -= sliding->limit.per_gap * change;
      sliding->force += sliding->stiffness * of.lead;
      sliding->velocity -= sliding->hold_rate * (of.lead - pair.normal.dot(of.lead) * pair.normal);
      pair.sliding = static_cast<int>(found.sliding.size());
      found.sliding.push_back(*sliding);
    }
  }
  found.pairs.push_back(pair);
}

// See keep_matrix_definite().
void SurfaceContact::make_definite(ContactPair& pair) {
  pair.stiffness = std::max(pair.stiffness, 0.0);
  pair.damping = std::max(pair.damping, 0.0);
}

void SurfaceContact::make_definite(const ContactPair& pair, Sliding& sliding) const {
  if (scene_.source.time.newton > 0 && iterate_ >= 0) use_secant(pair.normal, hold_rate_, sliding);
  if (pair.coefficient >= 0) return;
  sliding.slope.setZero();
  sliding.stiffness.setZero();
}

// See begin_newton().
void SurfaceContact::use_secants_past_rest(std::span<const Vec3> velocity) {
  if (iterate_ < 0) return;
  for (const ContactPair& pair : pairs_) {
    if (pair.sliding < 0 || iterate_ == 0) continue;
    Sliding& sliding = sliding_[pair.sliding];
    // An obstacle has the same velocity at all iterates. Its points may have been placed at one of
    // them only.
    const auto change_of = [&](int point) -> Vec3 {
      if (!is_dynamic(point)) return Vec3::Zero();
      return velocity[point] - last_velocity_[point];
    };
    Vec3 change = Vec3::Zero();
    for (int i = 0; i < 4; ++i) change += sliding.lever[i] * change_of(pair.nodes[i]);
    for (const SpinArm& spin : sliding.spins) {
      if (spin.point >= 0) change += spin.arm * pair.normal.cross(change_of(spin.point));
    }
    if (has_turned_back(pair.normal, change, sliding)) use_secant(pair.normal, hold_rate_, sliding);
  }
  ++iterate_;
  last_velocity_.assign(velocity.begin(), velocity.begin() + scene_.dynamic_points);
}

// Returns the value of the mollifier of two edges. Records the forces from its slope. They turn the
// edges towards parallel, because the barrier of parallel edges is zero.
double SurfaceContact::mollify(const Pair& pair, const bsi::Closest& closest,
                               std::span<const Vec3> position, const ContactLaw& law,
                               Found& found) const {
  const auto& [p0, p1, q0, q1] = pair.nodes;
  const Vec3 a = position[p1] - position[p0], b = position[q1] - position[q0];
  const materials::MollifierDerivatives m = materials::edge_edge_mollifier(
      a.cross(b).squaredNorm(), parallel_threshold(rest_, pair.nodes));
  const double gap = std::sqrt(closest.squared_distance) - pair.thickness;
  if (m.first == 0 || !(gap > 0)) return m.value;
  const double energy = materials::barrier(gap, law.range, law.stiffness).value;
  // The mollifier's argument is c = |a x b|^2, with dc/da = 2 (|b|^2 a - (a . b) b) and dc/db
  // likewise.
  const double dot = a.dot(b);
  const Vec3 on_a = -energy * m.first * 2 * (b.squaredNorm() * a - dot * b);
  const Vec3 on_b = -energy * m.first * 2 * (a.squaredNorm() * b - dot * a);
  found.mollified.push_back({pair.nodes, {-on_a, on_a, -on_b, on_b}});
  return m.value;
}

}  // namespace weft::sim
