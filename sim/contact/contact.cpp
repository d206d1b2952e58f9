#include "sim/contact/contact.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bsi/continuous_collision.h"
#include "materials/contact.h"
#include "sim/case/case_text.h"
#include "sim/parallel.h"

namespace weft::sim {

namespace {

bsi::Closest closest_of(bool edges, const std::array<int, 4>& nodes, std::span<const Vec3> x) {
  return edges ? bsi::closest_edge_edge(x[nodes[0]], x[nodes[1]], x[nodes[2]], x[nodes[3]])
               : bsi::closest_vertex_triangle(x[nodes[0]], x[nodes[1]], x[nodes[2]], x[nodes[3]]);
}

}  // namespace

// A point of a feature is a convex combination of its corners, and strays no further than the one
// of them that strays most.
double Contact::stray_of(const Pair& pair, std::span<const double> stray) {
  double side[2] = {0, 0};
  const int split = pair.edges ? 2 : 1;
  for (int i = 0; i < 4; ++i) {
    double& largest = side[i < split ? 0 : 1];
    largest = std::max(largest, stray[pair.nodes[i]]);
  }
  return side[0] + side[1];
}

std::string ContactFault::describe(const Scene& scene) const {
  const auto name = [&](int particle) { return scene.describe_particle(particle); };
  switch (kind) {
    case Kind::not_finite:
      return "the position of " + name(nodes[0]) + " is not finite";
    case Kind::touching:
      return "no gap is left between the features at " + name(nodes[0]) + " and " + name(nodes[3]) +
             " (gap " + number_text(gap) + " m)";
    case Kind::in_reach:
      return "the features at " + name(nodes[0]) + " and " + name(nodes[3]) +
             " are within reach of each other (gap " + number_text(gap) + " m)";
    case Kind::crossing:
      return "the features at " + name(nodes[0]) + " and " + name(nodes[3]) +
             " would pass through each other";
  }
  return "";
}

Contact::Contact(const Scene& scene, Statistics& statistics, ChosenSearch search)
    : scene_(scene),
      statistics_(statistics),
      search_(scene, statistics, std::move(search)),
      range_(scene.source.contact.range),
      stiffness_(scene.source.contact.stiffness),
      damping_time_(scene.source.contact.damping_time),
      friction_(scene.source.contact.friction),
      friction_speed_(scene.source.contact.friction_speed) {
  for (const SceneBody& body : scene.bodies)
    rest_.insert(rest_.end(), body.rest.begin(), body.rest.end());
}

std::array<int, 4> Contact::nodes_of(const CandidateList& list, int kind,
                                     const FeaturePair& features) const {
  const SceneBody& a = scene_.bodies[list.body_a];
  const SceneBody& b = scene_.bodies[list.body_b];
  if (kind == 2) {
    const auto& e = a.mesh.edges[features.a].vertex;
    const auto& f = b.mesh.edges[features.b].vertex;
    return {e[0] + a.first_particle, e[1] + a.first_particle, f[0] + b.first_particle,
            f[1] + b.first_particle};
  }
  const SceneBody& vertices = kind == 0 ? a : b;
  const SceneBody& triangles = kind == 0 ? b : a;
  const auto& t = triangles.mesh.triangles[features.b];
  const int first = triangles.first_particle;
  return {features.a + vertices.first_particle, t[0] + first, t[1] + first, t[2] + first};
}

// Mean area around the vertices of the side that is simulated; of both sides where both are.
// Obstacles' resolution then has no say in how stiff the contact is.
double Contact::pair_area(const std::array<int, 4>& nodes, int split) const {
  double sum[2] = {0, 0};
  for (int i = 0; i < 4; ++i) sum[i < split ? 0 : 1] += scene_.contact_area[nodes[i]];
  sum[0] /= split;
  sum[1] /= 4 - split;
  const bool first = nodes[0] < scene_.dynamic_particles,
             second = nodes[3] < scene_.dynamic_particles;
  if (first && second) return 0.5 * (sum[0] + sum[1]);
  return first ? sum[0] : sum[1];
}

// The candidates that may be closer than thickness + reach.
std::vector<Contact::PairGroup> Contact::groups_within(double reach) const {
  std::vector<PairGroup> groups;
  for (const CandidateList& list : search_.lists()) {
    const auto limit = static_cast<float>(list.thickness + reach + list.drift) * (1 + 1e-6F);
    const std::vector<FeaturePair>* kinds[3] = {&list.vertex_triangle, &list.triangle_vertex,
                                                &list.edge_edge};
    for (int kind = 0; kind < 3; ++kind) {
      PairGroup& group = groups.emplace_back();
      group.edges = kind == 2;
      group.thickness = list.thickness;
      group.body_a = list.body_a;
      group.body_b = list.body_b;
      for (const FeaturePair& features : *kinds[kind]) {
        if (features.distance <= limit) group.nodes.push_back(nodes_of(list, kind, features));
      }
    }
  }
  return groups;
}

// Calls visit(pair) for each of them.
template <class Visit>
void Contact::visit_candidates(double reach, const Visit& visit) const {
  for (const PairGroup& group : groups_within(reach))
    for (std::size_t i = 0; i < group.nodes.size(); ++i) visit(group.pair(i));
}

std::optional<ContactFault> Contact::evaluate(std::span<const Vec3> position,
                                              std::span<const Vec3> velocity, int threads) {
  active_.clear();
  mollified_.clear();
  if (const auto bad = search_.update(position))
    return ContactFault{ContactFault::Kind::not_finite, {*bad}};
  PhaseTimer timer(statistics_.phases.narrow_phase);
  for (const PairGroup& group : groups_within(range_)) {
    const int count = static_cast<int>(group.nodes.size());
    statistics_.counters.narrow_phase_calls += count;
    // Each chunk collects its own; they are joined in order, which keeps the sums in order too.
    std::vector<Found> found((count + chunk_size - 1) / chunk_size);
    parallel_chunks(count, threads, [&](int first, int last) {
      measure_part(group, first, last, position, velocity, found[first / chunk_size]);
    });
    for (const Found& part : found) {
      if (part.fault) {
        active_.clear();
        mollified_.clear();
        return part.fault;
      }
      active_.insert(active_.end(), part.active.begin(), part.active.end());
      mollified_.insert(mollified_.end(), part.mollified.begin(), part.mollified.end());
    }
  }
  if (friction_ > 0)
    statistics_.counters.friction_terms += static_cast<std::int64_t>(active_.size());
  return std::nullopt;
}

void Contact::measure_part(const PairGroup& group, std::size_t first, std::size_t last,
                           std::span<const Vec3> position, std::span<const Vec3> velocity,
                           Found& found) const {
  std::vector<bsi::PairInReach> in_reach;
  bsi::find_in_reach(group.kind(), position, {},
                     std::span(group.nodes).subspan(first, last - first), group.thickness + range_,
                     in_reach);
  for (const bsi::PairInReach& near : in_reach) {
    const Pair pair = group.pair(first + near.pair);
    Active active;
    MollifierForce mollified;
    bool has_mollified = false;
    const Reach reach = measure(pair, position, velocity, active, mollified, has_mollified);
    if (reach == Reach::touching) {
      found.fault = ContactFault{ContactFault::Kind::touching, pair.nodes, active.gap};
      return;
    }
    if (reach == Reach::in) found.active.push_back(active);
    if (reach == Reach::in && has_mollified) found.mollified.push_back(mollified);
  }
}

Contact::Reach Contact::measure(const Pair& pair, std::span<const Vec3> position,
                                std::span<const Vec3> velocity, Active& active,
                                MollifierForce& mollified, bool& has_mollified) const {
  const bsi::Closest closest = closest_of(pair.edges, pair.nodes, position);
  const double limit = pair.thickness + range_;
  if (closest.squared_distance >= limit * limit) return Reach::out;
  const double distance = std::sqrt(closest.squared_distance);
  active.gap = distance - pair.thickness;
  if (!(active.gap > 0)) return Reach::touching;
  active.nodes = pair.nodes;
  active.weight = closest.weight;
  materials::BarrierDerivatives barrier = materials::barrier(
      active.gap, range_, stiffness_ * pair_area(pair.nodes, pair.edges ? 2 : 1));
  const double mollifier =
      pair.edges ? mollify(pair, position, barrier.value, mollified, has_mollified) : 1.0;
  active.energy = mollifier * barrier.value;
  active.force = closest.separation * (-mollifier * barrier.first / distance);
  Vec3 relative = Vec3::Zero();
  for (int i = 0; i < 4; ++i) relative += closest.weight[i] * velocity[pair.nodes[i]];
  add_damping_and_friction(closest, relative, mollifier * barrier.first, mollifier * barrier.second,
                           mollifier * barrier.third, active);
  return Reach::in;
}

// `slope`, `curvature`, `third`: W', W'', W''' with respect to the gap.
void Contact::add_damping_and_friction(const bsi::Closest& closest, const Vec3& relative_velocity,
                                       double slope, double curvature, double third,
                                       Active& active) const {
  const Vec3 normal = closest.separation / std::sqrt(closest.squared_distance);
  const Mat3 projection = normal * normal.transpose();
  const double gap_rate = normal.dot(relative_velocity);
  // The barrier's push alone: with the damping's in it, which leaps at an impact, Newton's
  // iteration fails so often that five sheets falling on each other cost 2.5 times as much; at rest
  // and in steady sliding the two are the same.
  const double push = -slope;
  active.force += normal * (-damping_time_ * curvature * gap_rate);
  double stiffness = curvature + damping_time_ * third * gap_rate;
  if (definite_) stiffness = std::max(stiffness, 0.0);
  active.stiffness = stiffness * projection;
  active.damping = damping_time_ * curvature * projection;
  if (friction_ == 0 || push <= 0) return;
  const Vec3 sliding = relative_velocity - gap_rate * normal;
  const double speed = sliding.norm();
  const materials::FrictionFactor factor = materials::friction_factor(speed, friction_speed_);
  const double limit = friction_ * push;
  active.force -= limit * factor.over_speed * sliding;
  active.damping += limit * factor.over_speed * (Mat3::Identity() - projection);
  if (speed > 0) {
    active.damping += limit * (factor.slope - factor.over_speed) * (sliding / speed) *
                      (sliding / speed).transpose();
  }
}

// The mollifier's value; its slope pushes the edges apart from parallel.
double Contact::mollify(const Pair& pair, std::span<const Vec3> position, double barrier_value,
                        MollifierForce& mollified, bool& has_mollified) const {
  const auto& [p0, p1, q0, q1] = pair.nodes;
  const Vec3 a = position[p1] - position[p0], b = position[q1] - position[q0];
  const double threshold =
      1e-3 * (rest_[p1] - rest_[p0]).squaredNorm() * (rest_[q1] - rest_[q0]).squaredNorm();
  const materials::MollifierDerivatives m =
      materials::edge_edge_mollifier(a.cross(b).squaredNorm(), threshold);
  has_mollified = m.first != 0;
  if (!has_mollified) return m.value;
  // c = |a x b|^2: dc/da = 2 (|b|^2 a - (a.b) b), dc/db likewise.
  const double dot = a.dot(b);
  const Vec3 on_a = -barrier_value * m.first * 2 * (b.squaredNorm() * a - dot * b);
  const Vec3 on_b = -barrier_value * m.first * 2 * (a.squaredNorm() * b - dot * a);
  mollified.nodes = pair.nodes;
  mollified.force = {-on_a, on_a, -on_b, on_b};
  return m.value;
}

void Contact::add_forces(std::span<Vec3> force) const {
  const int dynamic = scene_.dynamic_particles;
  for (const Active& active : active_) {
    for (int i = 0; i < 4; ++i) {
      if (active.nodes[i] < dynamic) force[active.nodes[i]] += active.weight[i] * active.force;
    }
  }
  for (const MollifierForce& mollified : mollified_) {
    for (int i = 0; i < 4; ++i) {
      if (mollified.nodes[i] < dynamic) force[mollified.nodes[i]] += mollified.force[i];
    }
  }
}

double Contact::energy() const {
  double sum = 0;
  for (const Active& active : active_) sum += active.energy;
  return sum;
}

// out += sum over the pairs of weight_i block(pair) sum_j weight_j in_j.
template <class Block>
void Contact::add_pair_products(const Block& block, std::span<const Vec3> in,
                                std::span<Vec3> out) const {
  const int dynamic = scene_.dynamic_particles;
  for (const Active& active : active_) {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 4; ++i) {
      if (active.nodes[i] < dynamic) sum += active.weight[i] * in[active.nodes[i]];
    }
    const Vec3 product = block(active) * sum;
    for (int i = 0; i < 4; ++i) {
      if (active.nodes[i] < dynamic) out[active.nodes[i]] += active.weight[i] * product;
    }
  }
}

void Contact::add_product(double gamma, std::span<const Vec3> in, std::span<Vec3> out) const {
  add_pair_products(
      [&](const Active& active) {
        return Mat3(gamma * (gamma * active.stiffness + active.damping));
      },
      in, out);
}

void Contact::subtract_stiffness(double factor, std::span<const Vec3> in,
                                 std::span<Vec3> out) const {
  add_pair_products([&](const Active& active) { return Mat3(-factor * active.stiffness); }, in,
                    out);
}

void Contact::add_diagonal(double gamma, std::span<Mat3> diagonal) const {
  for (const Active& active : active_) {
    const Mat3 block = gamma * (gamma * active.stiffness + active.damping);
    for (int i = 0; i < 4; ++i) {
      if (active.nodes[i] >= scene_.dynamic_particles) continue;
      diagonal[active.nodes[i]] += active.weight[i] * active.weight[i] * block;
    }
  }
}

Contact::Coupling Contact::definite_coupling(std::size_t pair, double gamma) const {
  const Active& active = active_[pair];
  Mat3 block = gamma * (gamma * active.stiffness + active.damping);
  // Surfaces that part fast soften the barrier's own stiffness below zero.
  Eigen::SelfAdjointEigenSolver<Mat3> spectrum;
  spectrum.computeDirect(block);
  if (spectrum.eigenvalues()[0] < 0) {
    block = spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0).asDiagonal() *
            spectrum.eigenvectors().transpose();
  }
  return {active.nodes, active.weight, block};
}

std::optional<double> Contact::smallest_gap() const {
  if (active_.empty()) return std::nullopt;
  return std::min_element(active_.begin(), active_.end(),
                          [](const Active& p, const Active& q) { return p.gap < q.gap; })
      ->gap;
}

std::optional<ContactFault> Contact::check_path(std::span<const Vec3> start,
                                                std::span<const Vec3> end, const PathStray& stray) {
  return find_path_fault(start, end, {.gap = true, .stray = stray});
}

std::optional<ContactFault> Contact::check_crossing(std::span<const Vec3> start,
                                                    std::span<const Vec3> end) {
  return find_path_fault(start, end, {.gap = false, .stray = {}});
}

std::optional<ContactFault> Contact::find_path_fault(std::span<const Vec3> start,
                                                     std::span<const Vec3> end,
                                                     const PathDemand& demand) {
  if (const auto bad = search_.update_path(start, end, demand.stray.body)) {
    return ContactFault{ContactFault::Kind::not_finite, {*bad}};
  }
  PhaseTimer timer(statistics_.phases.narrow_phase);
  for (const PairGroup& group : groups_within(0.0)) {
    const int count = static_cast<int>(group.nodes.size());
    statistics_.counters.narrow_phase_calls += count;
    statistics_.counters.ccd_calls += count;
    std::vector<std::optional<ContactFault>> faults((count + chunk_size - 1) / chunk_size);
    parallel_chunks(count, scene_.source.compute.threads, [&](int first, int last) {
      faults[first / chunk_size] = check_part(group, first, last, start, end, demand);
    });
    for (const auto& fault : faults)
      if (fault) return fault;
  }
  return std::nullopt;
}

// The first fault of a part of the pairs: most are proved free of one at a look.
std::optional<ContactFault> Contact::check_part(const PairGroup& group, std::size_t first,
                                                std::size_t last, std::span<const Vec3> start,
                                                std::span<const Vec3> end,
                                                const PathDemand& demand) const {
  // Half the thickness: both ends keep all of it, so a path that is refused truly cuts through
  // something.
  const double half = demand.gap ? 0.5 * group.thickness : 0.0;
  const std::span<const double> stray = demand.stray.particle;
  // Of the whole group; pair by pair it may be less.
  double largest = half;
  if (!stray.empty()) largest += demand.stray.body[group.body_a] + demand.stray.body[group.body_b];
  std::vector<int> unproved;
  bsi::find_unproved_paths(group.kind(), start, end,
                           std::span(group.nodes).subspan(first, last - first), largest,
                           demand.gap ? std::max(group.thickness, largest) : largest, unproved);
  for (int i : unproved) {
    const Pair pair = group.pair(first + i);
    const bsi::Closest at_end = closest_of(pair.edges, pair.nodes, end);
    const double gap = std::sqrt(at_end.squared_distance) - pair.thickness;
    if (demand.gap && !(gap > 0)) {
      return ContactFault{ContactFault::Kind::touching, pair.nodes, gap};
    }
    double separation = half;
    if (!stray.empty()) separation += stray_of(pair, stray);
    bsi::FourPoints from, to;
    for (int k = 0; k < 4; ++k) {
      from[k] = start[pair.nodes[k]];
      to[k] = end[pair.nodes[k]];
    }
    const double safe = pair.edges ? bsi::safe_fraction_edge_edge(from, to, separation)
                                   : bsi::safe_fraction_vertex_triangle(from, to, separation);
    if (safe < 1) return ContactFault{ContactFault::Kind::crossing, pair.nodes, gap};
  }
  return std::nullopt;
}

std::optional<ContactFault> Contact::check_state(std::span<const Vec3> position,
                                                 double* smallest_gap) {
  if (const auto bad = search_.update(position))
    return ContactFault{ContactFault::Kind::not_finite, {*bad}};
  *smallest_gap = std::numeric_limits<double>::infinity();
  std::optional<ContactFault> fault;
  visit_candidates(range_, [&](const Pair& pair) {
    const double gap =
        std::sqrt(closest_of(pair.edges, pair.nodes, position).squared_distance) - pair.thickness;
    if (gap < *smallest_gap) *smallest_gap = gap;
    if (!(gap > 0) && !fault) fault = ContactFault{ContactFault::Kind::touching, pair.nodes, gap};
  });
  return fault;
}

std::optional<ContactFault> Contact::self_pair_in_reach(std::span<const Vec3> position) {
  if (const auto bad = search_.update(position))
    return ContactFault{ContactFault::Kind::not_finite, {*bad}};
  std::optional<ContactFault> found;
  visit_candidates(range_, [&](const Pair& pair) {
    if (found) return;
    const int body = scene_.body_index_of_particle(pair.nodes[0]);
    if (body != scene_.body_index_of_particle(pair.nodes[3])) return;
    const double gap =
        std::sqrt(closest_of(pair.edges, pair.nodes, position).squared_distance) - pair.thickness;
    if (gap < range_) found = ContactFault{ContactFault::Kind::in_reach, pair.nodes, gap};
  });
  return found;
}

}  // namespace weft::sim
