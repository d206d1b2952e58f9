#include "sim/contact/feature_collector.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include "bsi/detail/feature_batches.h"
#include "bsi/detail/team.h"
#include "sim/base/memory_shortage.h"
#include "sim/case/case_text.h"
#include "sim/case/memory_estimate.h"
#include "sim/contact/path_box.h"
#include "sim/contact/surface_features.h"

namespace weft::sim {

namespace {

using bsi::FeatureKind;
using bsi::FourParticles;

constexpr int quad_pairs_per_chunk = 256;

// Pairs of features whose distances are not yet known.
struct Batch {
  std::vector<FourParticles> points;
  std::vector<FeaturePair> features;

  void add(const FourParticles& four, int a, int b) {
    points.push_back(four);
    features.push_back({a, b, 0});
  }
};

// One entry per list of CandidateList, numbered by ListIndex.
constexpr int list_count = FeaturePairs::list_count;
using Batches = std::array<Batch, list_count>;
using Lists = std::array<std::vector<FeaturePair>, list_count>;
enum ListIndex {
  vertex_triangle,
  triangle_vertex,
  edge_edge,
  near_vertex_triangle,
  near_triangle_vertex,
  near_edge_edge
};

bool has_edges(int list) { return list == edge_edge || list == near_edge_edge; }
bool has_neighbours(int list) { return list >= near_vertex_triangle; }
bool is_swapped(int list) { return list == triangle_vertex || list == near_triangle_vertex; }

double reach_of(const ListReach& reach, int list) {
  switch (list) {
    case vertex_triangle:
      return reach.first_vertices;
    case triangle_vertex:
      return reach.second_vertices;
    case edge_edge:
      return reach.edges;
    default:
      return reach.neighbours;
  }
}

// The points, and the quads with such a point, whose pairs are found anew.
class RenewedParts {
 public:
  // `points` has one mark per surface point. If it is empty, all points have a mark. Where all
  // points of one body have a mark, every pair has one.
  RenewedParts(std::span<const char> points, const SceneBody& a, const SceneBody& b) {
    if (points.empty() || are_all_marked(points, a) || are_all_marked(points, b)) return;
    points_ = points;
    quads_a_ = quads_of(a);
    if (&a != &b) quads_b_ = quads_of(b);
  }

  // True if all pairs are found anew.
  bool are_all() const { return points_.empty(); }
  bool has_quad_of(const bsi::LeafPair& pair) const {
    const std::vector<char>& of_b = quads_b_.empty() ? quads_a_ : quads_b_;
    return are_all() || quads_a_[pair.a] != 0 || of_b[pair.b] != 0;
  }
  bool has_point_of(const FourParticles& points) const {
    return are_all() || std::ranges::any_of(points, [&](int point) { return points_[point] != 0; });
  }

 private:
  static bool are_all_marked(std::span<const char> points, const SceneBody& body) {
    return std::ranges::all_of(points.subspan(body.first_point, body.point_count()),
                               [](char mark) { return mark != 0; });
  }
  std::vector<char> quads_of(const SceneBody& body) const {
    if (body.spheres != nullptr) {
      const auto own = points_.subspan(body.first_point, body.point_count());
      return {own.begin(), own.end()};
    }
    const std::vector<std::array<int, 3>>& triangles = body.surface_mesh().triangles;
    std::vector<char> marks(triangles.size() / 2, 0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (const int corner : triangles[t]) marks[t / 2] |= points_[body.first_point + corner];
    }
    return marks;
  }

  std::span<const char> points_;
  std::vector<char> quads_a_, quads_b_;  // marks; the second is empty if both are the same body
};

// The features of a body, with the boxes around their paths.
class BoxedFeatures : public SurfaceFeatures {
 public:
  BoxedFeatures(const SceneBody& body, const PathEnds& path)
      : SurfaceFeatures(body),
        start_(path.start.subspan(body.first_point, body.point_count())),
        end_(path.end.subspan(body.first_point, body.point_count())),
        boxes_(path_boxes(start_, end_)) {
    PathBox all = boxes_.front();
    for (const PathBox& box : boxes_) all = united(all, box);
    size_ = (all.high - all.low).matrix().norm();
  }

  // The positions of the body's points at both ends of their paths, m.
  std::span<const Vec3> start() const { return start_; }
  std::span<const Vec3> end() const { return end_; }
  // Returns the diagonal of the box around all paths, m.
  double size() const { return size_; }
  const PathBox& vertex_box(int v) const { return boxes_[v]; }
  PathBox edge_box(int e) const {
    const auto& [a, b] = mesh().edges[e].vertex;
    return united(boxes_[a], boxes_[b]);
  }
  PathBox triangle_box(int t) const {
    const auto& [a, b, c] = mesh().triangles[t];
    return united(united(boxes_[a], boxes_[b]), boxes_[c]);
  }
  PathBox quad_box(int quad) const {
    return united(triangle_box(2 * quad), boxes_[mesh().triangles[2 * quad + 1][1]]);
  }

 private:
  std::span<const Vec3> start_, end_;
  double size_ = 0;
  std::vector<PathBox> boxes_;  // by point of the body
};

// Converts pairs of quads to pairs of their features, as far as boxes around these come within
// reach. Each thread uses a Gatherer of its own.
class Gatherer {
 public:
  Gatherer(const Scene& scene, const CandidateList& list, const BoxedFeatures& a,
           const BoxedFeatures& b, const ListReach& reach, const RenewedParts& renewed)
      : scene_(scene),
        self_(list.is_self()),
        reach_(reach),
        renewed_(renewed),
        a_(a),
        b_(b),
        quad_reach_((1 + 1e-12) *
                        std::max({reach.first_vertices, reach.second_vertices, reach.edges}) +
                    1e-14 * (a.size() + b.size())) {}

  const Batches& gather(std::span<const bsi::LeafPair> pairs) {
    for (Batch& batch : batches_) {
      batch.points.clear();
      batch.features.clear();
    }
    for (const bsi::LeafPair& pair : pairs) {
      if (!renewed_.has_quad_of(pair)) continue;
      if (a_.are_spheres() || b_.are_spheres()) {
        add_spheres(pair);
        continue;
      }
      if (is_watched(pair) || is_out_of_reach(pair) || are_distant_neighbours(pair)) continue;
      add_vertices(
          a_, pair.a, b_, pair.b,
          {reach_.first_vertices, reach_.first_near, vertex_triangle, near_vertex_triangle});
      if (!self_ || pair.a != pair.b) {
        add_vertices(
            b_, pair.b, a_, pair.a,
            {reach_.second_vertices, reach_.second_near, self_ ? vertex_triangle : triangle_vertex,
             self_ ? near_vertex_triangle : near_triangle_vertex});
      }
      add_edges(pair);
    }
    return batches_;
  }

 private:
  bool has_near() const { return reach_.first_near != nullptr && reach_.second_near != nullptr; }

  bool is_watched(const bsi::LeafPair& pair) const {
    return reach_.folds != nullptr && reach_.folds->covers(pair.a, pair.b);
  }

  // True if a plane across the line between the quads' centres keeps them out of reach. Boxes of
  // quads whose sides are not parallel to the axes meet long before the quads do, and boxes around
  // paths before that. On a fixed line the gap of two quads is never below those at both ends.
  bool is_out_of_reach(const bsi::LeafPair& pair) const {
    const auto a = corners_of(a_, pair.a), b = corners_of(b_, pair.b);
    Vec3 axis = Vec3::Zero();
    for (int k = 0; k < 4; ++k) axis += b_.end()[b[k]] - a_.end()[a[k]];
    const auto gap = [&](std::span<const Vec3> of_a, std::span<const Vec3> of_b) {
      const Vec3& origin = of_a[a[0]];
      double start = axis.dot(of_b[b[0]] - origin), end = 0;
      for (int k = 1; k < 4; ++k) {
        start = std::min(start, axis.dot(of_b[b[k]] - origin));
        end = std::max(end, axis.dot(of_a[a[k]] - origin));
      }
      return start - end;
    };
    const double needed = quad_reach_ * axis.norm();
    if (!(gap(a_.end(), b_.end()) > needed)) return false;
    return a_.start().data() == a_.end().data() || gap(a_.start(), b_.start()) > needed;
  }

  // True if all features of both quads are neighbours and stay out of reach of neighbours. On a
  // finely resolved surface, most pairs of quads in the list are of this kind.
  bool are_distant_neighbours(const bsi::LeafPair& pair) const {
    if (!has_near() || (self_ && pair.a == pair.b)) return false;
    const auto belong = [](const bsi::Neighbourhoods& near, const std::array<int, 4>& corners,
                           int quad) {
      return std::ranges::all_of(corners, [&](int v) { return near.contains_quad(v, quad); });
    };
    return are_apart(a_.quad_box(pair.a), b_.quad_box(pair.b), reach_.neighbours) &&
           belong(*reach_.first_near, corners_of(a_, pair.a), pair.b) &&
           belong(*reach_.second_near, corners_of(b_, pair.b), pair.a);
  }

  static std::array<int, 4> corners_of(const SurfaceFeatures& body, int quad) {
    const auto& first = body.mesh().triangles[2 * quad];
    return {first[0], first[1], first[2], body.mesh().triangles[2 * quad + 1][1]};
  }

  // The factor covers rounding.
  static bool are_apart(const PathBox& a, const PathBox& b, double reach) {
    return squared_gap(a, b) > (1 + 1e-12) * reach * reach;
  }

  // How far vertices are listed with triangles, their neighbourhoods, and the lists of pairs.
  struct VertexQuery {
    double reach;
    const bsi::Neighbourhoods* neighbourhoods;
    ListIndex list, near_list;
  };
  void add_vertices(const BoxedFeatures& vertices, int vertex_quad, const BoxedFeatures& triangles,
                    int triangle_quad, const VertexQuery& query) {
    for (int v : vertices.mesh().vertices_of_quad(vertex_quad)) {
      const int x0 = vertices.vertex(v);
      for (int t : {2 * triangle_quad, 2 * triangle_quad + 1}) {
        const auto [x1, x2, x3] = triangles.triangle(t);
        if (x0 == x1 || x0 == x2 || x0 == x3) continue;
        if (are_apart(vertices.vertex_box(v), triangles.triangle_box(t), query.reach)) continue;
        const bool near = query.neighbourhoods != nullptr && query.neighbourhoods->contains(v, t);
        add({x0, x1, x2, x3}, 1, v, t, batches_[near ? query.near_list : query.list]);
      }
    }
  }

  // Two spheres, or a sphere and a surface: its centre with the triangles, and vertices of cloth
  // with the sphere.
  void add_spheres(const bsi::LeafPair& pair) {
    if (a_.are_spheres() && b_.are_spheres()) {
      if (self_ && pair.a == pair.b) return;
      const int first = self_ ? std::min(pair.a, pair.b) : pair.a;
      const int second = self_ ? std::max(pair.a, pair.b) : pair.b;
      add_sphere(a_.vertex(first), first, b_, second, batches_[vertex_triangle]);
      return;
    }
    const bool is_first = a_.are_spheres();
    const SurfaceFeatures &spheres = is_first ? a_ : b_, &surface = is_first ? b_ : a_;
    const int sphere = is_first ? pair.a : pair.b, quad = is_first ? pair.b : pair.a;
    for (const int t : {2 * quad, 2 * quad + 1})
      add_sphere(spheres.vertex(sphere), sphere, surface, t,
                 batches_[is_first ? vertex_triangle : triangle_vertex]);
    if (is_first) return;
    for (const int v : surface.mesh().vertices_of_quad(quad))
      add_sphere(surface.vertex(v), v, spheres, sphere, batches_[vertex_triangle]);
  }

  // Adds a pair of a vertex, with its number in its body, and a triangle.
  void add_sphere(int point, int vertex, const SurfaceFeatures& triangles, int triangle,
                  Batch& out) {
    const auto [x1, x2, x3] = triangles.triangle(triangle);
    add({point, x1, x2, x3}, 1, vertex, triangle, out);
  }

  void add_edges(const bsi::LeafPair& pair) {
    const PathBox quad = b_.quad_box(pair.b);
    const std::span<const int> edges_b = b_.mesh().edges_of_quad(pair.b);
    boxes_b_.clear();
    for (int e : a_.mesh().edges_of_quad(pair.a)) {
      const PathBox box = a_.edge_box(e);
      if (are_apart(box, quad, reach_.edges)) continue;
      for (std::size_t k = boxes_b_.size(); k < edges_b.size(); ++k)
        boxes_b_.push_back(b_.edge_box(edges_b[k]));
      const auto [x0, x1] = a_.edge(e);
      for (std::size_t k = 0; k < edges_b.size(); ++k) {
        const int f = edges_b[k];
        if (self_ && pair.a == pair.b && f <= e) continue;
        if (are_apart(box, boxes_b_[k], reach_.edges)) continue;
        const auto [x2, x3] = b_.edge(f);
        if (x0 == x2 || x0 == x3 || x1 == x2 || x1 == x3) continue;
        const bool swap = self_ && f < e;
        add({x0, x1, x2, x3}, 2, swap ? f : e, swap ? e : f,
            batches_[are_near_edges(e, f) ? near_edge_edge : edge_edge]);
      }
    }
  }

  // True if an end of one edge has all triangles of the other edge in its neighbourhood.
  bool are_near_edges(int e, int f) const {
    if (!has_near()) return false;
    const bsi::Edge &one = a_.mesh().edges[e], &other = b_.mesh().edges[f];
    return std::ranges::any_of(one.vertex,
                               [&](int v) { return reach_.first_near->contains_edge(v, other); }) ||
           std::ranges::any_of(other.vertex,
                               [&](int v) { return reach_.second_near->contains_edge(v, one); });
  }

  // The first `split` points are those of the first feature.
  void add(const FourParticles& points, int split, int a, int b, Batch& out) const {
    if (!renewed_.has_point_of(points)) return;
    if (!scene_.sewn.is_empty() && scene_.sewn.are_joined(points, split)) return;
    const bool free = std::any_of(points.begin(), points.end(),
                                  [&](int point) { return scene_.is_free_point(point); });
    if (free) out.add(points, a, b);
  }

  const Scene& scene_;
  bool self_;
  const ListReach& reach_;
  const RenewedParts& renewed_;
  const BoxedFeatures &a_, &b_;
  double quad_reach_;  // m, largest reach, and more than rounding adds to the gap of two quads
  Batches batches_;
  std::vector<PathBox> boxes_b_;  // of the edges of the quad of b
};

// The pairs of features found in one chunk of quad pairs.
struct Found {
  Lists lists;
  std::int64_t looked_at = 0;
};

std::array<std::vector<FeaturePair>*, list_count> lists_of(FeaturePairs& pairs) {
  return {&pairs.vertex_triangle,      &pairs.triangle_vertex,      &pairs.edge_edge,
          &pairs.near_vertex_triangle, &pairs.near_triangle_vertex, &pairs.near_edge_edge};
}

// Takes all pairs out of the lists. Returns those that need not be found anew.
Found take_kept(const RenewedParts& renewed, const SurfaceFeatures& a, const SurfaceFeatures& b,
                FeaturePairs& pairs) {
  Found kept;
  for (int which = 0; which < list_count; ++which) {
    kept.lists[which].swap(*lists_of(pairs)[which]);
    if (renewed.are_all()) {
      kept.lists[which].clear();
      continue;
    }
    std::erase_if(kept.lists[which], [&](const FeaturePair& pair) {
      const bool swapped = is_swapped(which);
      return renewed.has_point_of(
          points_of(has_edges(which), swapped ? b : a, swapped ? a : b, pair));
    });
  }
  return kept;
}

void keep_in_reach(FeatureKind kind, const Batch& batch, const PathEnds& path, double reach,
                   std::vector<bsi::PairInReach>& in_reach, std::vector<FeaturePair>& out) {
  in_reach.clear();
  if (path.start.data() == path.end.data()) {
    bsi::find_in_reach(kind, path.end, batch.points, reach, in_reach);
  } else {
    bsi::find_in_reach_on_paths(kind, path.start, path.end, batch.points, reach, in_reach);
  }
  out.reserve(out.size() + in_reach.size());
  for (const bsi::PairInReach& found : in_reach) {
    FeaturePair features = batch.features[found.pair];
    const auto distance = static_cast<float>(found.distance);
    features.distance = std::max(0.0F, std::nextafter(distance, 0.0F));
    out.push_back(features);
  }
}

// Joins the lists with index `which` of all chunks. A counting sort orders the pairs by a, where 0
// <= a < count_a. The few pairs with the same a are then sorted by b.
void join_sorted(const std::vector<Found>& chunks, int which, std::size_t count_a, int threads,
                 std::vector<FeaturePair>& out) {
  std::vector<int> start(count_a + 1, 0);
  for (const Found& chunk : chunks)
    for (const FeaturePair& pair : chunk.lists[which]) ++start[pair.a + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  out.resize(start.back());
  std::vector<int> next(start.begin(), start.end() - 1);
  for (const Found& chunk : chunks)
    for (const FeaturePair& pair : chunk.lists[which]) out[next[pair.a]++] = pair;
  bsi::parallel_for(static_cast<int>(count_a), threads, [&](int a) {
    std::sort(out.begin() + start[a], out.begin() + start[a + 1],
              [](const FeaturePair& p, const FeaturePair& q) { return p.b < q.b; });
  });
}

// Memory of a pair (bytes): in the list of its chunk and, at the same time, in the joined list.
constexpr double bytes_per_pair = 2 * sizeof(FeaturePair);

[[noreturn]] void refuse_lists(const Scene& scene, const CandidateList& list) {
  const std::string &a = scene.bodies[list.body_a].name, &b = scene.bodies[list.body_b].name;
  throw MemoryShortage("the pairs of triangles and edges near each other of " + in_quotes(a) +
                           (list.is_self() ? "" : " and " + in_quotes(b)) +
                           " take more memory than the limit of " +
                           memory_text(memory_limit(scene.source)) +
                           ": thickness, contact.range or contact.search_slack is many edges long",
                       list.body_a, list.body_b);
}

}  // namespace

void collect_features(const Scene& scene, const CandidateList& list, const FeatureQuery& query,
                      FeaturePairs& pairs, Counters& counters) {
  const PathEnds& path = query.path;
  const ListReach& reach = query.reach;
  const std::span<const bsi::LeafPair> quad_pairs = query.quad_pairs;
  const SceneBody& a = scene.bodies[list.body_a];
  const SceneBody& b = scene.bodies[list.body_b];
  const RenewedParts parts(query.renewed, a, b);
  const int chunks =
      (static_cast<int>(quad_pairs.size()) + quad_pairs_per_chunk - 1) / quad_pairs_per_chunk;
  std::vector<Found> found(chunks + 1);
  found.back() = take_kept(parts, SurfaceFeatures(a), SurfaceFeatures(b), pairs);
  const BoxedFeatures of_a(a, path);
  const std::optional<BoxedFeatures> of_b =
      list.is_self() ? std::nullopt : std::optional<BoxedFeatures>(std::in_place, b, path);
  const int threads = scene.threads;
  bsi::SharedCount next(chunks);
  const auto most_pairs = static_cast<std::int64_t>(memory_limit(scene.source) / bytes_per_pair);
  std::atomic<std::int64_t> listed = 0;
  bsi::run_team(std::min(threads, chunks), [&] {
    Gatherer gatherer(scene, list, of_a, of_b ? *of_b : of_a, reach, parts);
    std::vector<bsi::PairInReach> in_reach;
    for (int c = 0; next.take(c) && listed <= most_pairs;) {
      const std::size_t first = static_cast<std::size_t>(c) * quad_pairs_per_chunk;
      const Batches& batches = gatherer.gather(quad_pairs.subspan(
          first, std::min<std::size_t>(quad_pairs_per_chunk, quad_pairs.size() - first)));
      for (int which = 0; which < list_count; ++which) {
        keep_in_reach(has_edges(which) ? FeatureKind::edge_edge : FeatureKind::vertex_triangle,
                      batches[which], path, reach_of(reach, which), in_reach,
                      found[c].lists[which]);
        found[c].looked_at += static_cast<std::int64_t>(batches[which].features.size());
        listed += std::ssize(found[c].lists[which]);
      }
    }
  });
  if (listed > most_pairs) refuse_lists(scene, list);
  const auto lists = lists_of(pairs);
  for (int which = 0; which < list_count; ++which) {
    if (has_neighbours(which) && reach.first_near == nullptr && reach.second_near == nullptr)
      continue;
    const std::size_t count = has_edges(which)    ? a.surface_mesh().edges.size()
                              : is_swapped(which) ? b.point_count()
                                                  : a.point_count();
    join_sorted(found, which, count, threads, *lists[which]);
    counters.candidate_pairs += static_cast<std::int64_t>(lists[which]->size());
  }
  for (const Found& chunk : found) counters.narrow_phase_calls += chunk.looked_at;
}

}  // namespace weft::sim
