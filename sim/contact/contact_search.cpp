#include "sim/contact/contact_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "bsi/proximity.h"
#include "sim/contact/feature_collector.h"

namespace weft::sim {

namespace {

// Distance (m) from the origin at which a point counts as lost.
constexpr double lost_distance = 1e15;

// Distance by which a moving body's box is widened on every side, as a fraction of its diagonal.
// With more room, boxes have more neighbours. With less room, bodies leave their boxes more often.
constexpr double room = 0.125;

// Returns the default slack: a quarter of the mean length of the edges of dynamic bodies at rest,
// m.
double default_slack(const Scene& scene) {
  double sum = 0;
  std::size_t count = 0;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const std::vector<bsi::Edge>& edges = scene.bodies[b].surface_mesh().edges;
    const std::vector<Vec3>& rest = scene.bodies[b].surface_rest();
    for (const bsi::Edge& edge : edges) sum += (rest[edge.vertex[0]] - rest[edge.vertex[1]]).norm();
    count += edges.size();
  }
  return 0.25 * sum / static_cast<double>(count);
}

// Returns a sphere around the points of both lists. It need not be the smallest, because it only
// bounds the distance of two bodies.
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

// Extends the box by the points. Returns the sum of the points. The sum is NaN if a point is NaN,
// whereas the box ignores NaN.
Vec3 extend(BodyTree::Box& box, std::span<const Vec3> points) {
  Vec3 low = box.min(), high = box.max(), sum = Vec3::Zero();
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    sum += p;
  }
  box = BodyTree::Box(low, high);
  return sum;
}

BodyTree::Box widened(const BodyTree::Box& box, double by) {
  const Vec3 more = Vec3::Constant(by);
  return {box.min() - more, box.max() + more};
}

// Returns the distance (m) by which the box of a body is widened. Bodies whose widened boxes do not
// meet are farther apart than thickness + range.
double half_reach(const Scene& scene, const SceneBody& body) {
  return 0.5 * (body.thickness + scene.source.contact.range);
}

bool is_searched(const Scene& scene, const BodyPair& pair) {
  return pair.a < scene.dynamic_bodies && (pair.a != pair.b || scene.bodies[pair.a].self_contact);
}

CandidateList empty_list(const Scene& scene, const BodyPair& pair) {
  CandidateList list;
  list.body_a = pair.a;
  list.body_b = pair.b;
  list.thickness = 0.5 * (scene.bodies[pair.a].thickness + scene.bodies[pair.b].thickness);
  return list;
}

// Returns the pairs of bodies, sorted, that contain one of `bodies`, that the contact search
// covers, and whose boxes meet. Adds the number of boxes compared to `compared`.
std::vector<BodyPair> searched_neighbours(const Scene& scene, const BodyTree& tree,
                                          std::span<const int> bodies, int& compared) {
  std::vector<BodyPair> pairs;
  const auto add = [&](int a, int b) {
    const BodyPair pair{std::min(a, b), std::max(a, b)};
    if (is_searched(scene, pair)) pairs.push_back(pair);
  };
  for (const int body : bodies) {
    add(body, body);
    compared += tree.visit_neighbours(body, [&](int other) { add(body, other); });
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

std::vector<CandidateList> searched_pairs(const Scene& scene) {
  std::vector<CandidateList> lists;
  const int bodies = static_cast<int>(scene.bodies.size());
  for (int a = 0; a < scene.dynamic_bodies; ++a) {
    for (int b = a; b < bodies; ++b) {
      if (is_searched(scene, {a, b})) lists.push_back(empty_list(scene, {a, b}));
    }
  }
  return lists;
}

std::vector<CandidateList> neighbours_at_start(const Scene& scene) {
  std::vector<BodyTree::Box> boxes;
  std::vector<int> all(scene.bodies.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<Vec3> room;
  const std::span<const Vec3> position =
      scene.surface_map.points_of(scene.initial_position, scene.point_count, room);
  for (const SceneBody& body : scene.bodies) {
    const double reach = half_reach(scene, body) + 0.5 * search_slack(scene);
    BodyTree::Box& box = boxes.emplace_back();
    extend(box, position.subspan(body.first_point, body.point_count()));
    boxes.back() = widened(box, reach);
  }
  BodyTree tree;
  tree.build(std::move(boxes));
  std::vector<CandidateList> lists;
  int compared = 0;
  for (const BodyPair& pair : searched_neighbours(scene, tree, all, compared))
    lists.push_back(empty_list(scene, pair));
  return lists;
}

double search_slack(const Scene& scene) {
  return scene.source.contact.search_slack.value_or(default_slack(scene));
}

double neighbour_radius(const SceneBody& body, double range) {
  const bsi::Neighbourhoods near(body.surface_mesh(), body.surface_rest(), body.thickness + range);
  return near.are_rings() ? 0 : std::numbers::pi / 2 * body.thickness + range;
}

ContactSearch::ContactSearch(const Scene& scene, Statistics& statistics, ChosenSearch search)
    : scene_(scene),
      statistics_(statistics),
      range_(scene.source.contact.range),
      slack_(search_slack(scene)),
      obstacles_(scene),
      tracked_(scene.bodies.size()),
      placed_(scene.bodies.size(), 0),
      search_(std::move(search)) {
  for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) {
    if (scene.bodies[b].moves) moving_.push_back(b);
    find_neighbourhoods(b);
  }
}

void ContactSearch::find_neighbourhoods(int b) {
  const SceneBody& body = scene_.bodies[b];
  if (!is_searched(scene_, {b, b})) return;
  auto found = std::make_unique<const bsi::Neighbourhoods>(
      body.surface_mesh(), body.surface_rest(), neighbour_radius(body, range_), scene_.threads);
  if (!found->are_rings()) tracked_[b].neighbourhoods = std::move(found);
}

std::span<const Vec3> ContactSearch::of_body(std::span<const Vec3> all, int body) const {
  return all.subspan(scene_.bodies[body].first_point, scene_.bodies[body].point_count());
}

ContactSearch::Displacement ContactSearch::displacement(std::span<const Vec3> snapshot,
                                                        std::span<const Vec3> now) {
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

// Returns a point of the body that is not finite or farther than lost_distance from the origin, if
// any.
std::optional<int> ContactSearch::find_lost(std::span<const Vec3> position, int body) const {
  const auto points = of_body(position, body);
  const auto lost = std::find_if(points.begin(), points.end(), [](const Vec3& p) {
    return !(p.squaredNorm() < lost_distance * lost_distance);
  });
  if (lost == points.end()) return std::nullopt;
  return scene_.bodies[body].first_point + static_cast<int>(lost - points.begin());
}

// A point p of the obstacle, at t = 0, has moved by d + (R1 - R0) (p - middle), where d is the
// displacement of its middle. The spectral norm of R1 - R0 is its Frobenius norm over the square
// root of two, because its two nonzero singular values are equal.
ContactSearch::Displacement ContactSearch::displacement(const RigidObstacle& obstacle,
                                                        const RigidPose& snapshot,
                                                        const RigidPose& now) {
  Displacement moved;
  moved.mean = now.place(obstacle.middle) - snapshot.place(obstacle.middle);
  moved.residual = std::numbers::sqrt2 / 2 * (now.rotation - snapshot.rotation).norm() *
                   obstacle.radius * (1 + 1e-9);
  return moved;
}

std::optional<int> ContactSearch::track(const PlacedPoints& now, bool from_start) {
  for (const int b : moving_) {
    const int number = obstacles_.of_body(b);
    bool is_finite = false;
    if (now.pose(number) != nullptr) {
      is_finite = track_pose(obstacles_.all()[number], now, from_start);
    } else {
      if (tracked_[b].pose) fill_snapshot(obstacles_.all()[number]);
      is_finite = track_points(b, of_body(now.position(), b), from_start);
    }
    const Box& box = tracked_[b].box;
    const bool is_near =
        box.min().minCoeff() > -lost_distance / 2 && box.max().maxCoeff() < lost_distance / 2;
    if (is_finite && is_near) continue;
    if (now.pose(number) != nullptr) now.place_all(obstacles_.all()[number]);
    if (const auto lost = find_lost(now.position(), b)) return lost;
  }
  return std::nullopt;
}

// Finds the displacement of an obstacle from its pose or, if its snapshot consists of points, from
// its points. Extends its box. Returns true if the pose or the points are finite.
bool ContactSearch::track_pose(const RigidObstacle& obstacle, const PlacedPoints& now,
                               bool from_start) {
  Tracked& tracked = tracked_[obstacle.body];
  const RigidPose& pose = *now.pose(obstacle.number);
  if (!tracked.snapshot.empty()) {
    now.place_all(obstacle);
    return track_points(obstacle.body, of_body(now.position(), obstacle.body), from_start);
  }
  tracked.box.extend(obstacle.box(pose));
  if (tracked.pose) {
    tracked.now = displacement(
        obstacle, from_start && tracked.path_start_pose ? *tracked.path_start_pose : *tracked.pose,
        pose);
  }
  return pose.rotation.allFinite() && pose.translation.allFinite();
}

bool ContactSearch::track_points(int body, std::span<const Vec3> now, bool from_start) {
  Tracked& tracked = tracked_[body];
  const std::span<const Vec3> from = from_start && !tracked.path_start.empty()
                                         ? std::span<const Vec3>(tracked.path_start)
                                         : tracked.snapshot;
  const Vec3 sum = extend(tracked.box, now);
  if (!from.empty()) tracked.now = displacement(from, now);
  return sum.allFinite();
}

// Replaces the poses of an obstacle's snapshot by positions of its points, for updates without
// poses.
void ContactSearch::fill_snapshot(const RigidObstacle& obstacle) {
  Tracked& tracked = tracked_[obstacle.body];
  for (const Vec3& start : obstacle.start()) {
    tracked.snapshot.push_back(tracked.pose->place(start));
    if (tracked.path_start_pose)
      tracked.path_start.push_back(tracked.path_start_pose->place(start));
  }
  tracked.pose.reset();
  tracked.path_start_pose.reset();
}

// Returns the sum (m) of the strays of both bodies. Strays change the distance between points of
// the two bodies by no more than this sum.
double ContactSearch::stray(const CandidateList& list) const {
  return tracked_[list.body_a].stray + tracked_[list.body_b].stray;
}

double ContactSearch::drift(const CandidateList& list, const Displacement& a,
                            const Displacement& b) {
  if (list.is_self()) return 2 * a.residual;
  return a.residual + b.residual + (a.mean - b.mean).norm();
}

// Returns an upper bound (m) of the change of any distance since the list was built. At equal times
// on two straight paths, displacements are convex combinations of the displacements at the ends,
// with the same weights for both bodies. The change is therefore no larger than at one of the ends.
double ContactSearch::drift(const CandidateList& list) const {
  const Tracked& a = tracked_[list.body_a];
  const Tracked& b = tracked_[list.body_b];
  return std::max(drift(list, a.now, b.now), drift(list, a.at_start, b.at_start)) + stray(list);
}

bool ContactSearch::is_valid(std::size_t list) const {
  const CandidateList& candidates = lists_[list];
  const ListState& state = states_[list];
  if (!state.built) return false;
  if (state.near) return drift(candidates) <= slack_ + state.stray;
  const Tracked& a = tracked_[candidates.body_a];
  const Tracked& b = tracked_[candidates.body_b];
  const double gone = a.path_length + a.largest() + b.path_length + b.largest() - state.path_length;
  return gone + stray(candidates) <= state.clearance;
}

bool ContactSearch::are_valid() const {
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    if (!is_valid(l)) return false;
  }
  return true;
}

// Marks bodies that need a new snapshot. These are the bodies of lists that are no longer valid,
// and all moving bodies connected to them by lists with `near`. A new snapshot of a body
// invalidates all its lists with `near`.
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

std::optional<int> ContactSearch::update(const PlacedPoints& now) {
  for (const int b : moving_) {
    tracked_[b].stray = 0;
    tracked_[b].box.setEmpty();
  }
  if (const auto bad = track(now)) return bad;
  for (const int b : moving_) tracked_[b].at_start = tracked_[b].now;
  find_neighbours(now.position());
  refresh(now, now);
  return std::nullopt;
}

std::optional<int> ContactSearch::update_path(const PlacedPoints& start, const PlacedPoints& end,
                                              std::span<const double> stray) {
  for (const int b : moving_) {
    tracked_[b].stray = stray.empty() ? 0 : stray[b];
    tracked_[b].box.setEmpty();
  }
  // The change of a distance from one straight path to another, at equal times, is at most the
  // larger of its changes at the starts and at the ends. The lists of one path therefore also serve
  // other paths with nearby starts and ends, such as those of Newton's iterations.
  if (const auto bad = track(start, true)) return bad;
  for (const int b : moving_) tracked_[b].at_start = tracked_[b].now;
  if (const auto bad = track(end)) return bad;
  find_neighbours(end.position());
  refresh(start, end);
  return std::nullopt;
}

// Returns the box that the body's box in the tree must contain. Bodies are then farther apart than
// thickness + range if their boxes in the tree do not meet.
ContactSearch::Box ContactSearch::needed_box(int body) const {
  const Tracked& tracked = tracked_[body];
  return widened(tracked.box, tracked.stray + half_reach(scene_, scene_.bodies[body]));
}

ContactSearch::Box ContactSearch::enlarged_box(int body) const {
  const Box needed = needed_box(body);
  return scene_.bodies[body].moves ? widened(needed, room * needed.diagonal().norm()) : needed;
}

void ContactSearch::find_neighbours(std::span<const Vec3> position) {
  if (!tree_.is_built()) return place_all(position);
  std::vector<int> left;
  std::vector<Box> boxes;
  for (const int b : moving_) {
    if (tree_.box(b).contains(needed_box(b))) continue;
    left.push_back(b);
    boxes.push_back(enlarged_box(b));
  }
  if (left.empty()) return;
  tree_.move(left, boxes);
  replace_lists(left);
}

void ContactSearch::place_all(std::span<const Vec3> position) {
  std::vector<int> all(tracked_.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<Box> boxes;
  for (const int b : all) {
    if (!scene_.bodies[b].moves) extend(tracked_[b].box, of_body(position, b));
    boxes.push_back(enlarged_box(b));
  }
  tree_.build(std::move(boxes));
  replace_lists(all);
}

// Updates the set of lists after the bodies `placed` got new boxes. The lists of these bodies are
// then those of their new neighbours.
void ContactSearch::replace_lists(std::span<const int> placed) {
  int compared = 0;
  const std::vector<BodyPair> pairs = searched_neighbours(scene_, tree_, placed, compared);
  statistics_.counters.bound_tests += compared;
  for (const int b : placed) placed_[b] = 1;
  std::vector<BodyPair> before;
  for (const CandidateList& list : lists_) {
    if (placed_[list.body_a] != 0 || placed_[list.body_b] != 0)
      before.push_back({list.body_a, list.body_b});
  }
  if (before != pairs) merge_lists(pairs);
  for (const int b : placed) placed_[b] = 0;
}

// Keeps the lists of `pairs` and the lists of bodies without new boxes. Removes other lists and
// adds the missing ones.
void ContactSearch::merge_lists(std::span<const BodyPair> pairs) {
  std::vector<CandidateList> lists;
  std::vector<ListState> states;
  const auto add = [&](const BodyPair& pair) {
    lists.push_back(empty_list(scene_, pair));
    states.push_back(first_state(lists.back()));
  };
  auto next = pairs.begin();
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    const BodyPair pair{lists_[l].body_a, lists_[l].body_b};
    while (next != pairs.end() && *next < pair) add(*next++);
    const bool is_kept = next != pairs.end() && *next == pair;
    if (is_kept) ++next;
    if (!is_kept && (placed_[pair.a] != 0 || placed_[pair.b] != 0)) continue;
    lists.push_back(std::move(lists_[l]));
    states.push_back(states_[l]);
  }
  while (next != pairs.end()) add(*next++);
  lists_.swap(lists);
  states_.swap(states);
}

// Returns the state of the list of a new pair. If both bodies have bounding spheres, the spheres
// may exclude the pair at once.
ContactSearch::ListState ContactSearch::first_state(const CandidateList& list) {
  const Tracked& a = tracked_[list.body_a];
  const Tracked& b = tracked_[list.body_b];
  ListState state;
  if (list.is_self() || a.bounds.radius < 0 || b.bounds.radius < 0) return state;
  ++statistics_.counters.bound_tests;
  state.built = true;
  state.clearance = bsi::bounding_sphere_gap(a.bounds, b.bounds) - list.thickness - range_;
  state.path_length = a.path_length + b.path_length;
  return state;
}

void ContactSearch::refresh(const PlacedPoints& start, const PlacedPoints& end) {
  statistics_.counters.body_pairs += static_cast<std::int64_t>(lists_.size());
  if (!are_valid()) rebuild_lists(start, end);
  for (CandidateList& list : lists_) list.drift = drift(list);
}

void ContactSearch::rebuild_lists(const PlacedPoints& start, const PlacedPoints& end) {
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
}

void ContactSearch::refresh_body(int body, const PlacedPoints& start, const PlacedPoints& end) {
  Tracked& tracked = tracked_[body];
  const int number = obstacles_.of_body(body);
  const bool is_path = !start.is_same(end);
  tracked.path_length += tracked.largest();
  tracked.now = tracked.at_start = {};
  tracked.pyramid_built = false;
  tracked.path_start.clear();
  if (const RigidPose* pose = end.pose(number)) {
    tracked.snapshot.clear();
    tracked.pose = *pose;
    tracked.path_start_pose = is_path ? std::optional(*start.pose(number)) : std::nullopt;
    tracked.bounds = obstacles_.all()[number].sphere(*start.pose(number), *pose);
    return;
  }
  const auto from = of_body(start.position(), body), position = of_body(end.position(), body);
  if (scene_.bodies[body].moves) {
    tracked.snapshot.assign(position.begin(), position.end());
    if (is_path) tracked.path_start.assign(from.begin(), from.end());
  }
  tracked.bounds = sphere_around(from, position);
}

// Clears a list that must be rebuilt. Returns true if the bounding spheres keep its bodies apart
// and the list therefore stays empty.
bool ContactSearch::rule_out(std::size_t l) {
  CandidateList& list = lists_[l];
  ListState& state = states_[l];
  const Tracked& a = tracked_[list.body_a];
  const Tracked& b = tracked_[list.body_b];
  list.vertex_triangle.clear();
  list.triangle_vertex.clear();
  list.edge_edge.clear();
  list.near_vertex_triangle.clear();
  list.near_edge_edge.clear();
  state.built = true;
  state.near = true;
  state.stray = stray(list);
  if (list.is_self()) return false;
  ++statistics_.counters.bound_tests;
  const double clearance = bsi::bounding_sphere_gap(a.bounds, b.bounds) - list.thickness - range_;
  state.near = clearance <= slack_ + state.stray;
  if (state.near) return false;
  // The spheres contain the bodies at their snapshots, so displacements since the snapshots count
  // against the clearance.
  state.clearance = clearance;
  state.path_length = a.path_length + b.path_length;
  return true;
}

BodyPath ContactSearch::path_of(int body, const PlacedPoints& start,
                                const PlacedPoints& end) const {
  BodyPath path{body, of_body(start.position(), body), of_body(end.position(), body)};
  const int number = obstacles_.of_body(body);
  const RigidPose *from = start.pose(number), *to = end.pose(number);
  if (to == nullptr) return path;
  const RigidObstacle& obstacle = obstacles_.all()[number];
  if (search_.search->takes_frames()) {
    path.obstacle = &obstacle;
    path.frames = {obstacle.frame(*from), obstacle.frame(*to)};
  } else {
    start.place_all(obstacle);
    end.place_all(obstacle);
  }
  return path;
}

// Rebuilds the pyramids of bodies whose lists are being built, unless they are up to date.
void ContactSearch::rebuild_pyramids(const PlacedPoints& start, const PlacedPoints& end) {
  PhaseTimer timer(statistics_.phases.rebuild);
  std::vector<BodyPath> paths;
  for (const PairQuery& query : queries_) {
    for (const int body : {query.body_a, query.body_b}) {
      if (tracked_[body].pyramid_built) continue;
      tracked_[body].pyramid_built = true;
      paths.push_back(path_of(body, scene_.bodies[body].moves ? start : end, end));
    }
  }
  statistics_.counters.rebuilds += search_.search->rebuild(paths);
}

void ContactSearch::find_quad_pairs(const PlacedPoints& start, const PlacedPoints& end) {
  rebuild_pyramids(start, end);
  bsi::TraversalCounters tests;
  PhaseTimer timer(statistics_.phases.traverse);
  search_.search->find(queries_, quad_pairs_, tests);
  statistics_.counters.bound_tests += tests.bound_tests;
}

// Computes the corners of all quads found on obstacles that are given by their poses.
void ContactSearch::place_found(const PlacedPoints& start, const PlacedPoints& end) {
  marks_.begin(scene_.point_count);
  for (std::size_t i = 0; i < building_.size(); ++i) {
    const int number = obstacles_.of_body(queries_[i].body_b);
    if (end.pose(number) == nullptr) continue;
    const RigidObstacle& obstacle = obstacles_.all()[number];
    const bsi::Atlas& atlas = scene_.bodies[obstacle.body].surface_atlas();
    for (const bsi::LeafPair& pair : quad_pairs_[i]) {
      for (const int corner : atlas.quad_particles(pair.b)) {
        const int point = obstacle.first_point + corner;
        if (!marks_.is_new(point)) continue;
        end.place(obstacle, point);
        if (!start.is_same(end)) start.place(obstacle, point);
      }
    }
  }
}

void ContactSearch::build_lists(const PlacedPoints& start, const PlacedPoints& end) {
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
  if (!obstacles_.all().empty()) place_found(start, end);
  for (std::size_t i = 0; i < building_.size(); ++i) {
    CandidateList& list = lists_[building_[i]];
    collect_features(
        scene_, {start.position(), end.position()}, quad_pairs_[i],
        {reach(list), slack_ + stray(list), list.is_self() ? neighbourhoods(list.body_a) : nullptr},
        list, statistics_.counters);
  }
}

}  // namespace weft::sim
