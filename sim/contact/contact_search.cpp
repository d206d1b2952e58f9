#include "sim/contact/contact_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "sim/base/parallel.h"
#include "sim/contact/device_contact.h"
#include "sim/contact/feature_collector.h"
#include "sim/contact/pair_selection.h"
#include "sim/contact/rest_neighbours.h"

namespace weft::sim {

namespace {

// Distance by which a moving body's box is widened on every side, as a fraction of its diagonal.
// With more room, boxes have more neighbours. With less room, bodies leave their boxes more often.
constexpr double room = 0.125;

// Paths longer than this part of the slack are recorded as paths. Shorter ones are recorded at
// their ends, where the steps that follow begin.
constexpr double short_path = 0.125;

// Length of the paths on which points are expected, as a part of the slack. With longer paths,
// lists last longer, but contain more pairs.
constexpr double path_ahead = 1.5;

// Part of the slack by which points move until candidates are selected anew. With less, they are
// selected more often; with more, there are more of them.
constexpr double part_for_candidates = 0.0625;

// Room, as a part of the slack, that adjacent quads need for lists to leave them out. With less,
// quads that fold have their pairs found again and again. Larger rooms are measured up to the
// second number. They last longer, but their pairs take longer to measure.
constexpr double least_room_for_folds = 0.25, largest_room_for_folds = 3;

// Returns the default slack: a sixth of the mean length of the edges of dynamic bodies at rest, m.
// Without edges, it is a sixth of the smallest radius of particles.
double default_slack(const Scene& scene) {
  double sum = 0;
  std::size_t count = 0;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const std::vector<bsi::Edge>& edges = scene.bodies[b].surface_mesh().edges;
    const std::vector<Vec3>& rest = scene.bodies[b].surface_rest();
    for (const bsi::Edge& edge : edges) sum += (rest[edge.vertex[0]] - rest[edge.vertex[1]]).norm();
    count += edges.size();
  }
  if (count == 0)
    return std::ranges::min(scene.source.particles, {}, &ParticlesCase::radius).radius / 6;
  return sum / (6 * static_cast<double>(count));
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
  if (scene.bodies[pair.a].are_spins || scene.bodies[pair.b].are_spins) return false;
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
    BodyTree::Box box;
    for (const Vec3& p : position.subspan(body.first_point, body.point_count())) box.extend(p);
    boxes.push_back(widened(box, reach));
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

ContactSearch::ContactSearch(const Scene& scene, Statistics& statistics, ChosenSearch search)
    : scene_(scene),
      statistics_(statistics),
      range_(scene.source.contact.range),
      slack_(search_slack(scene)),
      candidate_slack_(part_for_candidates * slack_),
      motion_(scene),
      neighbourhoods_(scene.bodies.size()),
      folds_(scene.bodies.size()),
      folded_(scene.dynamic_points, 0),
      placed_(scene.bodies.size(), 0),
      renewals_(scene.bodies.size()),
      placed_pyramid_(scene.bodies.size(), 0),
      own_pyramid_(scene.bodies.size(), 0),
      search_(std::move(search)) {
  if (!scene.seams.empty()) find_neighbours_across_seams();
  for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) find_neighbourhoods(b);
}

std::unique_ptr<DeviceContact> ContactSearch::make_device_contact() const {
  return search_.search->make_device_contact();
}

void ContactSearch::find_neighbourhoods(int b) {
  const SceneBody& body = scene_.bodies[b];
  if (!is_searched(scene_, {b, b}) || body.spheres != nullptr) return;
  auto found = std::make_unique<const bsi::Neighbourhoods>(
      body.surface_mesh(), body.surface_rest(), neighbour_radius(body, range_), scene_.threads);
  if (const auto more = across_seams_.find({b, b}); more != across_seams_.end())
    found = united(body, *found, *more->second);
  if (!found->are_rings()) neighbourhoods_[b] = std::move(found);
  folds_[b] = std::make_unique<bsi::FoldWatch>(
      body.surface_atlas(), body.surface_mesh(), neighbourhoods_[b].get(),
      bsi::FoldWatch::Reach{.vertices = body.thickness + range_,
                            .edges = body.thickness + short_range * range_},
      largest_room_for_folds * slack_);
}

std::optional<int> ContactSearch::update(const PlacedPoints& now, std::span<const Vec3> velocity) {
  return follow({now, now}, {}, velocity);
}

std::optional<int> ContactSearch::update_path(const PlacedPoints& start, const PlacedPoints& end,
                                              std::span<const double> stray) {
  return follow({start, end}, stray, {});
}

std::optional<int> ContactSearch::follow(const PointPaths& paths, std::span<const double> stray,
                                         std::span<const Vec3> velocity) {
  if (const auto lost = motion_.follow(paths, stray, velocity)) return lost;
  find_neighbours();
  refresh();
  return std::nullopt;
}

// Returns the box that the body's box in the tree must contain. Bodies are then farther apart than
// thickness + range if their boxes in the tree do not meet.
ContactSearch::Box ContactSearch::needed_box(int body) const {
  return widened(motion_.box(body), motion_.stray(body) + half_reach(scene_, scene_.bodies[body]));
}

ContactSearch::Box ContactSearch::enlarged_box(int body) const {
  const Box needed = needed_box(body);
  return scene_.bodies[body].moves ? widened(needed, room * needed.diagonal().norm()) : needed;
}

// Gives new boxes to bodies that have left their boxes, and updates the set of lists.
void ContactSearch::find_neighbours() {
  if (!tree_.is_built()) return place_all();
  std::vector<int> left;
  std::vector<Box> boxes;
  for (const int b : motion_.moving()) {
    if (tree_.box(b).contains(needed_box(b))) continue;
    left.push_back(b);
    boxes.push_back(enlarged_box(b));
  }
  if (left.empty()) return;
  tree_.move(left, boxes);
  replace_lists(left);
}

void ContactSearch::place_all() {
  std::vector<int> all(scene_.bodies.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<Box> boxes;
  boxes.reserve(all.size());
  for (const int b : all) boxes.push_back(enlarged_box(b));
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
    set_across(lists.back());
    states.emplace_back();
  };
  auto next = pairs.begin();
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    const BodyPair pair{lists_[l].body_a, lists_[l].body_b};
    while (next != pairs.end() && *next < pair) add(*next++);
    const bool is_kept = next != pairs.end() && *next == pair;
    if (is_kept) ++next;
    if (!is_kept && (placed_[pair.a] != 0 || placed_[pair.b] != 0)) continue;
    lists.push_back(std::move(lists_[l]));
    states.push_back(std::move(states_[l]));
  }
  while (next != pairs.end()) add(*next++);
  lists_.swap(lists);
  ++changes_;
  states_.swap(states);
}

// Makes all lists complete. Lists whose slack is used up let go of bodies that are far apart, or
// have the points recorded anew that have moved most.
void ContactSearch::refresh() {
  statistics_.counters.body_pairs += static_cast<std::int64_t>(lists_.size());
  building_.clear();
  find_near_lists();
  measure();
  if (find_expired()) {
    do {
      renew();
    } while (find_torn());
    build_lists();
    motion_.forget_renewed();
  }
  select_candidates();
}

// Returns true if the boxes around the present paths of both bodies are farther apart than
// `distance`.
bool ContactSearch::are_apart(const CandidateList& list, double distance) const {
  if (list.is_self()) return false;
  return motion_.box(list.body_a).squaredExteriorDistance(motion_.box(list.body_b)) >
         distance * distance;
}

void ContactSearch::find_near_lists() {
  for (const int b : near_bodies_) renewals_[b] = {};
  near_bodies_.clear();
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    const CandidateList& list = lists_[l];
    ListState& state = states_[l];
    if (!state.near) {
      ++statistics_.counters.bound_tests;
      const double strays = stray(list);
      if (are_apart(list, list.thickness + range_ + strays)) continue;
      state = {};
      state.near = state.whole = true;
      state.stray = strays;
    }
    for (const int b : {list.body_a, list.body_b}) {
      Renewal& renewal = renewals_[b];
      if (!renewal.has_pairs && !renewal.has_own_pairs) near_bodies_.push_back(b);
      (list.is_self() ? renewal.has_own_pairs : renewal.has_pairs) = true;
      renewal.has_moving_pairs |= !list.is_self() && scene_.bodies[list.body_b].moves;
    }
  }
}

void ContactSearch::measure() {
  for (const int b : near_bodies_) {
    if (renewals_[b].has_pairs) motion_.measure_placed(b, renewals_[b].has_moving_pairs);
    if (renewals_[b].has_own_pairs) motion_.measure_own(b);
  }
}

// Returns an upper bound (m) of the change of any distance since the snapshot.
double ContactSearch::drift(const CandidateList& list) const {
  return stray(list) + (list.is_self() ? motion_.own_change(list.body_a)
                                       : motion_.change(list.body_a, list.body_b));
}

// Finds the lists that may be incomplete, and asks for new records of their bodies. Returns false
// if there are none.
bool ContactSearch::find_expired() {
  bool any = false;
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    CandidateList& list = lists_[l];
    ListState& state = states_[l];
    if (!state.near) continue;
    const bool has_folds = list.is_self() && find_folds(list);
    if (!has_folds && !state.whole && drift(list) <= list_slack(l)) continue;
    const double needed = list.thickness + range_ + stray(list);
    if (!state.whole && are_apart(list, std::max(needed, reach(l)))) {
      clear(l);
      continue;
    }
    ask_for_renewal(l);
    any = true;
  }
  return any;
}

// Finds the lists of bodies of which one has been recorded anew and the other one not, although
// both had moved far together, and asks for new records of both. Returns false if there are none. A
// body is asked for until no point is left that has moved by its limit, so this ends.
bool ContactSearch::find_torn() {
  bool any = false;
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    if (!states_[l].near || drift(lists_[l]) <= list_slack(l)) continue;
    ask_for_renewal(l);
    any = true;
  }
  return any;
}

// Marks the points of adjacent quads that may have come within reach of each other, so that their
// pairs are found. Returns true if there are any.
bool ContactSearch::find_folds(const CandidateList& list) {
  bsi::FoldWatch* const folds = folds_[list.body_a].get();
  if (folds == nullptr) return false;
  PhaseTimer timer(statistics_.phases.narrow_phase);
  const SceneBody& body = scene_.bodies[list.body_a];
  const BodyPaths paths = motion_.present(list.body_a);
  return folds->follow({paths.start, paths.end}, stray(list),
                       std::span(folded_).subspan(body.first_point, body.point_count()),
                       scene_.threads);
}

// Asks for new records of the points that have used up a fifth of their share of the slack. With a
// larger part, fewer points are recorded at a time, but more often.
void ContactSearch::ask_for_renewal(std::size_t l) {
  const CandidateList& list = lists_[l];
  ListState& state = states_[l];
  // Half of the slack is left for strays that grow. Room for strays of the past is given up when it
  // exceeds the slack.
  const double now = stray(list);
  if (now > state.stray + 0.5 * slack_ || now < state.stray - slack_) {
    state.whole = true;
    state.stray = now;
  }
  const bool both_move = list.is_self() || scene_.bodies[list.body_b].moves;
  const double limit = (both_move ? 0.1 : 0.2) * slack_;
  if (list.is_self()) {
    renewals_[list.body_a].own_limit = limit;
    return;
  }
  for (const int b : {list.body_a, list.body_b}) {
    if (!scene_.bodies[b].moves && motion_.placed().has(b)) continue;
    renewals_[b].placed_limit = std::min(renewals_[b].placed_limit, limit);
  }
}

// Records the points that have moved too far, and finds the lists that must be built.
void ContactSearch::renew() {
  building_.clear();
  for (const int b : near_bodies_) {
    const Renewal& renewal = renewals_[b];
    const auto rules = [&](double limit, std::span<const char> others) {
      return RecordRules{limit, short_path * slack_, path_ahead * slack_, others};
    };
    if (std::isfinite(renewal.placed_limit)) {
      motion_.renew_placed(b, rules(renewal.placed_limit, {}));
      placed_pyramid_[b] = 0;
    }
    if (std::isfinite(renewal.own_limit)) {
      motion_.renew_own(b, rules(renewal.own_limit, folded_));
      own_pyramid_[b] = 0;
    }
  }
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    const auto& [a, b] = std::pair(lists_[l].body_a, lists_[l].body_b);
    const bool renewed = lists_[l].is_self()
                             ? motion_.own().is_renewed(a)
                             : motion_.placed().is_renewed(a) || motion_.placed().is_renewed(b);
    if (!states_[l].near || !(renewed || states_[l].whole)) continue;
    building_.push_back(l);
  }
}

// Removes all pairs of a list, and marks it as far.
void ContactSearch::clear(std::size_t l) {
  states_[l] = {};
  static_cast<FeaturePairs&>(lists_[l]) = {};
  lists_[l].version = ++changes_;
}

double ContactSearch::growth_since_choice(const CandidateList& list) const {
  return stray(list) + (list.is_self() ? motion_.own_growth(list.body_a)
                                       : motion_.growth(list.body_a, list.body_b));
}

// The vertices of dynamic bodies are samples.
double ContactSearch::range_of_vertices(const CandidateList& list, int body) const {
  return scene_.bodies[body].dynamic ? range_ : range_of_edges(list);
}

// Returns true if the candidates of a list may be incomplete.
bool ContactSearch::is_outdated(std::size_t l) const {
  return states_[l].near && !states_[l].pairs.is_empty() &&
         growth_since_choice(lists_[l]) > candidate_slack_ + states_[l].selected_stray;
}

// Selects candidates anew where lists have been built or candidates may be incomplete. Lists of two
// bodies share the positions from which candidates are selected, so all of them are selected at
// once. A list of one body with itself has positions of its own.
void ContactSearch::select_candidates() {
  std::vector<char> is_built(lists_.size(), 0);
  for (const std::size_t l : building_) is_built[l] = 1;
  bool some_placed = false;
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    if (is_built[l] == 0 && !is_outdated(l)) continue;
    if (lists_[l].is_self()) {
      motion_.choose_own(lists_[l].body_a);
      select(l);
    } else {
      some_placed = true;
    }
  }
  if (some_placed) select_of_two_bodies();
  for (std::size_t l = 0; l < lists_.size(); ++l)
    lists_[l].drift = states_[l].pairs.is_empty() ? 0 : growth_since_choice(lists_[l]);
}

void ContactSearch::select_of_two_bodies() {
  std::vector<char> has_pairs(scene_.bodies.size(), 0);
  for (std::size_t l = 0; l < lists_.size(); ++l) {
    if (lists_[l].is_self() || states_[l].pairs.is_empty()) continue;
    has_pairs[lists_[l].body_a] = has_pairs[lists_[l].body_b] = 1;
  }
  for (const int b : motion_.moving())
    if (has_pairs[b] != 0) motion_.choose_placed(b);
  for (std::size_t l = 0; l < lists_.size(); ++l)
    if (!lists_[l].is_self()) select(l);
}

// Selects the candidates of a list.
void ContactSearch::select(std::size_t l) {
  using Feature = BodyMotion::Feature;
  CandidateList& list = lists_[l];
  list.version = ++changes_;
  ListState& state = states_[l];
  state.selected_stray = stray(list);
  const auto motion = [&](int body, Feature kind) {
    return motion_.features(body, kind, list.is_self());
  };
  const double reach = candidate_slack_ + state.selected_stray;
  list.for_each_with(state.pairs, [&](auto& selected, auto& all, bool edges, bool near) {
    selected.clear();
    if (all.empty()) return;
    const bool swapped =
        &selected == &list.triangle_vertex || &selected == &list.near_triangle_vertex;
    const int one = swapped ? list.body_b : list.body_a;
    const int other = swapped ? list.body_a : list.body_b;
    const double range = edges ? range_of_edges(list) : range_of_vertices(list, one);
    const double distance = reach + (near ? 0 : list.thickness + range);
    const PairSelection selection(all, distance,
                                  motion(one, edges ? Feature::edge : Feature::vertex),
                                  motion(other, edges ? Feature::edge : Feature::triangle));
    const auto select_part = [&](int first, int last, Selected& part) {
      part.pairs = selection.take(first, last, part.room);
    };
    for (const Selected& part :
         parallel_parts(selected_, static_cast<int>(all.size()), scene_.threads, select_part))
      selected.insert(selected.end(), part.pairs.begin(), part.pairs.end());
  });
}

// Rebuilds the pyramids of bodies whose lists are being built, unless they are up to date.
void ContactSearch::rebuild_pyramids() {
  PhaseTimer timer(statistics_.phases.rebuild);
  std::vector<BodyPath> paths;
  for (const PairQuery& query : queries_) {
    const bool own = query.body_a == query.body_b;
    for (const int body : {query.body_a, query.body_b}) {
      char& is_built = (own ? own_pyramid_ : placed_pyramid_)[body];
      if (is_built != 0) continue;
      is_built = 1;
      paths.push_back(own ? motion_.own_path(body)
                          : motion_.placed_path(body, !search_.search->takes_frames()));
    }
  }
  statistics_.counters.rebuilds += search_.search->rebuild(paths);
}

void ContactSearch::find_quad_pairs() {
  rebuild_pyramids();
  bsi::TraversalCounters tests;
  PhaseTimer timer(statistics_.phases.traverse);
  search_.search->find(queries_, quad_pairs_, tests);
  statistics_.counters.bound_tests += tests.bound_tests;
}

// Computes the corners of all quads found on obstacles that are given by their poses.
void ContactSearch::place_found() {
  motion_.begin_placing();
  for (std::size_t i = 0; i < building_.size(); ++i) {
    if (!motion_.is_posed(queries_[i].body_b)) continue;
    for (const bsi::LeafPair& pair : quad_pairs_[i]) motion_.place_quad(queries_[i].body_b, pair.b);
  }
}

void ContactSearch::build_lists() {
  if (building_.empty()) return;
  queries_.clear();
  for (const std::size_t l : building_) {
    queries_.push_back({lists_[l].body_a, lists_[l].body_b, reach(l)});
    ++(lists_[l].is_self() ? statistics_.counters.self_traversals
                           : statistics_.counters.pair_traversals);
  }
  try {
    find_quad_pairs();
  } catch (const std::runtime_error& error) {
    if (compute().backend == ComputeBackend::cpu) throw;
    search_ = {make_cpu_search(scene_),
               {ComputeBackend::cpu, "", compute().text() + ", which failed: " + error.what()}};
    placed_pyramid_.assign(placed_pyramid_.size(), 0);
    own_pyramid_.assign(own_pyramid_.size(), 0);
    find_quad_pairs();
  }
  PhaseTimer timer(statistics_.phases.narrow_phase);
  if (!obstacles().all().empty()) place_found();
  for (std::size_t i = 0; i < building_.size(); ++i) {
    const std::size_t l = building_[i];
    const CandidateList& list = lists_[l];
    const Snapshot& snapshot = list.is_self() ? motion_.own() : motion_.placed();
    const bool has_paths = snapshot.has_paths(list.body_a) || snapshot.has_paths(list.body_b);
    const PathEnds ends{has_paths ? snapshot.start() : snapshot.end(), snapshot.end()};
    bsi::FoldWatch* const folds = list.is_self() ? folds_[list.body_a].get() : nullptr;
    if (folds != nullptr) {
      const BodyPaths paths = motion_.present(list.body_a);
      folds->close({paths.start, paths.end}, stray(list), least_room_for_folds * slack_,
                   scene_.threads);
    }
    const double others = list.thickness + list_slack(l);
    const ListReach reaches{
        .first_vertices = others + range_,
        .second_vertices = others + range_of_vertices(list, list.body_b),
        .edges = others + range_of_edges(list),
        .neighbours = list_slack(l),
        .first_near = list.is_self() ? neighbourhoods(list.body_a) : list.first_across,
        .second_near = list.is_self() ? neighbourhoods(list.body_a) : list.second_across,
        .folds = folds};
    const auto renewed = states_[l].whole ? std::span<const char>() : snapshot.renewed();
    collect_features(scene_, list, {ends, quad_pairs_[i], reaches, renewed}, states_[l].pairs,
                     statistics_.counters);
    states_[l].whole = false;
  }
  std::ranges::fill(folded_, 0);
}

}  // namespace weft::sim
