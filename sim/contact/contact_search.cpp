#include "sim/contact/contact_search.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bsi/proximity.h"
#include "sim/contact/feature_collector.h"

namespace weft::sim {

namespace {

constexpr double lost_distance = 1e15;  // m

// A quarter of the mean edge: lists a few times longer than what touches, and rebuilt every few
// tens of steps.
double default_slack(const Scene& scene) {
  double sum = 0;
  std::size_t count = 0;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    for (const bsi::Edge& edge : body.mesh.edges) {
      sum += (body.rest[edge.vertex[0]] - body.rest[edge.vertex[1]]).norm();
    }
    count += body.mesh.edges.size();
  }
  return 0.25 * sum / static_cast<double>(count);
}

// Any sphere around the points will do: this one is only asked how far two bodies are apart.
bsi::Sphere sphere_around(std::span<const Vec3> first, std::span<const Vec3> second) {
  Vec3 low = first[0], high = first[0];
  for (const auto& points : {first, second}) {
    for (const Vec3& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  const Eigen::Vector3f centre = (0.5 * (low + high)).cast<float>();
  const double radius = (high - low).norm() / 2 + 1e-6 * (low.cwiseAbs() + high.cwiseAbs()).norm();
  return {centre[0], centre[1], centre[2], std::nextafter(static_cast<float>(radius), INFINITY)};
}

}  // namespace

std::vector<CandidateList> searched_pairs(const Scene& scene) {
  std::vector<CandidateList> lists;
  const int bodies = static_cast<int>(scene.bodies.size());
  for (int a = 0; a < scene.dynamic_bodies; ++a) {
    for (int b = a; b < bodies; ++b) {
      if (a == b && !scene.bodies[a].self_contact) continue;
      CandidateList list;
      list.body_a = a;
      list.body_b = b;
      list.thickness = 0.5 * (scene.bodies[a].thickness + scene.bodies[b].thickness);
      lists.push_back(std::move(list));
    }
  }
  return lists;
}

double search_slack(const Scene& scene) {
  return scene.source.contact.search_slack.value_or(default_slack(scene));
}

ContactSearch::ContactSearch(const Scene& scene, Statistics& statistics, ChosenSearch search)
    : scene_(scene),
      statistics_(statistics),
      range_(scene.source.contact.range),
      slack_(search_slack(scene)),
      tracked_(scene.bodies.size()),
      lists_(searched_pairs(scene)),
      states_(lists_.size()),
      search_(std::move(search)) {}

std::span<const Vec3> ContactSearch::of_body(std::span<const Vec3> all, int body) const {
  return all.subspan(scene_.bodies[body].first_particle, scene_.bodies[body].particle_count());
}

ContactSearch::Displacement ContactSearch::displacement(std::span<const Vec3> snapshot,
                                                        std::span<const Vec3> now) const {
  Displacement moved;
  for (std::size_t i = 0; i < snapshot.size(); ++i) moved.mean += now[i] - snapshot[i];
  moved.mean /= static_cast<double>(std::max<std::size_t>(1, snapshot.size()));
  double largest = 0;
  for (std::size_t i = 0; i < snapshot.size(); ++i) {
    largest = std::max(largest, (now[i] - snapshot[i] - moved.mean).squaredNorm());
  }
  moved.residual = std::sqrt(largest);
  return moved;
}

std::optional<int> ContactSearch::track(std::span<const Vec3> position, bool from_start) {
  for (std::size_t b = 0; b < tracked_.size(); ++b) {
    if (tracked_[b].snapshot.empty()) continue;
    tracked_[b].now =
        displacement(from_start && !tracked_[b].path_start.empty() ? tracked_[b].path_start
                                                                   : tracked_[b].snapshot,
                     of_body(position, static_cast<int>(b)));
    // A sum keeps a NaN that a maximum would swallow. What has flown this far is as lost, and
    // float32 spheres could not hold it.
    const auto is_lost = [](const Vec3& p) {
      return !(p.squaredNorm() < lost_distance * lost_distance);
    };
    if (tracked_[b].now.mean.allFinite() && tracked_[b].now.largest() < lost_distance / 2) continue;
    const auto body = of_body(position, static_cast<int>(b));
    const auto bad = std::find_if(body.begin(), body.end(), is_lost);
    if (bad != body.end())
      return scene_.bodies[b].first_particle + static_cast<int>(bad - body.begin());
  }
  return std::nullopt;
}

// By how much the distance of two points of its bodies may differ from that on the straight paths.
double ContactSearch::stray(const CandidateList& list) const {
  return tracked_[list.body_a].stray + tracked_[list.body_b].stray;
}

double ContactSearch::drift(const CandidateList& list) const {
  const Displacement& a = tracked_[list.body_a].now;
  const Displacement& b = tracked_[list.body_b].now;
  if (list.is_self()) return 2 * a.residual + stray(list);
  return a.residual + b.residual + (a.mean - b.mean).norm() + stray(list);
}

bool ContactSearch::is_valid(std::size_t list) const {
  const CandidateList& candidates = lists_[list];
  const ListState& state = states_[list];
  if (!state.built) return false;
  if (state.near) return drift(candidates) <= slack_ + state.stray;
  const Tracked& a = tracked_[candidates.body_a];
  const Tracked& b = tracked_[candidates.body_b];
  const double gone =
      a.path_length + a.now.largest() + b.path_length + b.now.largest() - state.path_length;
  return gone + stray(candidates) <= state.clearance;
}

// The bodies of the lists that ran out and, since a new snapshot voids every list built from the
// old one, all moving bodies tied to them by further lists.
std::vector<char> ContactSearch::bodies_to_refresh() const {
  std::vector<char> marked(tracked_.size(), 0);
  const auto mark = [&](int body) {
    const bool fresh =
        marked[body] == 0 && (scene_.bodies[body].moves || tracked_[body].bounds.radius < 0);
    marked[body] |= fresh;
    return fresh;
  };
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    if (is_valid(l)) continue;
    mark(lists_[l].body_a);
    mark(lists_[l].body_b);
  }
  for (bool grew = true; grew;) {
    grew = false;
    for (std::size_t l = 0; l < lists_.size(); ++l) {
      if (!states_[l].near) continue;
      if (marked[lists_[l].body_a] != 0 && mark(lists_[l].body_b)) grew = true;
      if (marked[lists_[l].body_b] != 0 && mark(lists_[l].body_a)) grew = true;
    }
  }
  return marked;
}

std::optional<int> ContactSearch::update(std::span<const Vec3> position) {
  for (Tracked& tracked : tracked_) tracked.stray = 0;
  if (const auto bad = track(position)) return bad;
  refresh(position, position);
  return std::nullopt;
}

std::optional<int> ContactSearch::update_path(std::span<const Vec3> start,
                                              std::span<const Vec3> end,
                                              std::span<const double> stray) {
  for (std::size_t b = 0; b < tracked_.size(); ++b)
    tracked_[b].stray = stray.empty() ? 0 : stray[b];
  // From one straight path to another, distances change by no more than between their starts or
  // their ends. So lists of one path serve those beside it: Newton's iterations leave from one
  // place, far from where they lead.
  if (const auto bad = track(start, true)) return bad;
  std::vector<Displacement> at_start;
  for (const Tracked& tracked : tracked_) at_start.push_back(tracked.now);
  if (const auto bad = track(end)) return bad;
  for (std::size_t b = 0; b < tracked_.size(); ++b) {
    Displacement& now = tracked_[b].now;
    now.residual =
        std::max(now.residual, at_start[b].residual) + (now.mean - at_start[b].mean).norm();
  }
  refresh(start, end);
  return std::nullopt;
}

void ContactSearch::refresh(std::span<const Vec3> start, std::span<const Vec3> end) {
  const std::vector<char> marked = bodies_to_refresh();
  std::vector<char> stale(lists_.size(), 0);
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    const bool new_snapshot = marked[lists_[l].body_a] != 0 || marked[lists_[l].body_b] != 0;
    stale[l] = !is_valid(l) || (states_[l].near && new_snapshot);
  }
  for (std::size_t b = 0; b < tracked_.size(); ++b) {
    if (marked[b] != 0) refresh_body(static_cast<int>(b), start, end);
  }
  building_.clear();
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    if (stale[l] != 0 && !rule_out(l)) building_.push_back(l);
  }
  if (!building_.empty()) build_lists(start, end);
  for (CandidateList& list : lists_) list.drift = drift(list);
}

void ContactSearch::refresh_body(int body, std::span<const Vec3> start, std::span<const Vec3> end) {
  Tracked& tracked = tracked_[body];
  tracked.path_length += tracked.now.largest();
  tracked.now = {};
  const auto position = of_body(end, body);
  if (scene_.bodies[body].moves) {
    const auto from = of_body(start, body);
    tracked.snapshot.assign(position.begin(), position.end());
    tracked.path_start.clear();
    if (start.data() != end.data()) tracked.path_start.assign(from.begin(), from.end());
  }
  tracked.bounds = sphere_around(of_body(start, body), position);
  tracked.pyramid_built = false;
}

// Empties a list that is to be built anew; true if the bounding spheres keep its bodies apart, so
// that it stays empty.
bool ContactSearch::rule_out(std::size_t l) {
  CandidateList& list = lists_[l];
  ListState& state = states_[l];
  const Tracked& a = tracked_[list.body_a];
  const Tracked& b = tracked_[list.body_b];
  list.vertex_triangle.clear();
  list.triangle_vertex.clear();
  list.edge_edge.clear();
  state.built = true;
  state.near = true;
  state.stray = stray(list);
  if (list.is_self()) return false;
  ++statistics_.counters.bound_tests;
  const double clearance = bsi::bounding_sphere_gap(a.bounds, b.bounds) - list.thickness - range_;
  state.near = clearance <= slack_ + state.stray;
  if (state.near) return false;
  // The spheres bound the bodies at their snapshots: what has been gone since then counts already.
  state.clearance = clearance;
  state.path_length = a.path_length + b.path_length;
  return true;
}

// Of the bodies whose lists are being built, where they have moved.
void ContactSearch::rebuild_pyramids(std::span<const Vec3> start, std::span<const Vec3> end) {
  PhaseTimer timer(statistics_.phases.rebuild);
  std::vector<BodyPath> paths;
  for (const PairQuery& query : queries_) {
    for (const int body : {query.body_a, query.body_b}) {
      if (tracked_[body].pyramid_built) continue;
      tracked_[body].pyramid_built = true;
      const std::span<const Vec3> from = scene_.bodies[body].moves ? start : end;
      paths.push_back({body, of_body(from, body), of_body(end, body)});
    }
  }
  search_.search->rebuild(paths);
  statistics_.counters.rebuilds += static_cast<std::int64_t>(paths.size());
}

void ContactSearch::find_quad_pairs(std::span<const Vec3> start, std::span<const Vec3> end) {
  rebuild_pyramids(start, end);
  bsi::TraversalCounters tests;
  PhaseTimer timer(statistics_.phases.traverse);
  search_.search->find(queries_, quad_pairs_, tests);
  statistics_.counters.bound_tests += tests.bound_tests;
}

void ContactSearch::build_lists(std::span<const Vec3> start, std::span<const Vec3> end) {
  queries_.clear();
  for (const std::size_t l : building_) {
    queries_.push_back({lists_[l].body_a, lists_[l].body_b, reach(lists_[l])});
    ++(lists_[l].is_self() ? statistics_.counters.self_traversals
                           : statistics_.counters.pair_traversals);
  }
  try {
    find_quad_pairs(start, end);
  } catch (const std::runtime_error& error) {
    if (compute().backend == ComputeBackend::cpu) throw;
    search_ = {make_cpu_search(scene_),
               {ComputeBackend::cpu, "", compute().text() + ", which failed: " + error.what()}};
    for (Tracked& tracked : tracked_) tracked.pyramid_built = false;
    find_quad_pairs(start, end);
  }
  PhaseTimer timer(statistics_.phases.narrow_phase);
  for (std::size_t i = 0; i < building_.size(); ++i) {
    CandidateList& list = lists_[building_[i]];
    collect_features(scene_, start, end, quad_pairs_[i], reach(list), list, statistics_.counters);
  }
}

}  // namespace weft::sim
