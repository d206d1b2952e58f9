#include "sim/contact/feature_collector.h"

#include <algorithm>
#include <cmath>

#include "bsi/proximity.h"

namespace weft::sim {

namespace {

// The features of one side, in global particle indices.
struct Side {
  const SceneBody& body;
  int first;
  explicit Side(const SceneBody& from) : body(from), first(from.first_particle) {}

  int vertex(int v) const { return v + first; }
  std::array<int, 2> edge(int e) const {
    const auto& [a, b] = body.mesh.edges[e].vertex;
    return {a + first, b + first};
  }
  std::array<int, 3> triangle(int t) const {
    const auto& [a, b, c] = body.mesh.triangles[t];
    return {a + first, b + first, c + first};
  }
};

class Collector {
 public:
  Collector(const Scene& scene, std::span<const Vec3> start, std::span<const Vec3> end,
            double reach, CandidateList& list, Counters& counters)
      : scene_(scene),
        start_(start),
        end_(end),
        swept_(start.data() != end.data()),
        reach_(reach),
        list_(list),
        counters_(counters),
        a_(scene.bodies[list.body_a]),
        b_(scene.bodies[list.body_b]) {}

  void add_quads(const bsi::LeafPair& pair) {
    add_vertices(a_, pair.a, b_, pair.b, list_.vertex_triangle);
    if (!list_.is_self()) {
      add_vertices(b_, pair.b, a_, pair.a, list_.triangle_vertex);
    } else if (pair.a != pair.b) {
      add_vertices(b_, pair.b, a_, pair.a, list_.vertex_triangle);
    }
    add_edges(pair);
  }

 private:
  void add_vertices(const Side& vertices, int vertex_quad, const Side& triangles, int triangle_quad,
                    std::vector<FeaturePair>& out) {
    for (int v : vertices.body.mesh.vertices_of_quad(vertex_quad)) {
      const int x0 = vertices.vertex(v);
      for (int t : {2 * triangle_quad, 2 * triangle_quad + 1}) {
        const auto [x1, x2, x3] = triangles.triangle(t);
        if (x0 == x1 || x0 == x2 || x0 == x3) continue;
        const std::array<int, 4> nodes{x0, x1, x2, x3};
        if (const float d = distance_if_near(nodes, 1, bsi::closest_vertex_triangle); d >= 0) {
          out.push_back({v, t, d});
        }
      }
    }
  }

  void add_edges(const bsi::LeafPair& pair) {
    for (int e : a_.body.mesh.edges_of_quad(pair.a)) {
      const auto [x0, x1] = a_.edge(e);
      for (int f : b_.body.mesh.edges_of_quad(pair.b)) {
        if (list_.is_self() && pair.a == pair.b && f <= e) continue;
        const auto [x2, x3] = b_.edge(f);
        if (x0 == x2 || x0 == x3 || x1 == x2 || x1 == x3) continue;
        const std::array<int, 4> nodes{x0, x1, x2, x3};
        if (const float d = distance_if_near(nodes, 2, bsi::closest_edge_edge); d >= 0) {
          const bool swap = list_.is_self() && f < e;
          list_.edge_edge.push_back({swap ? f : e, swap ? e : f, d});
        }
      }
    }
  }

  // Distance (a lower bound on the path) of a pair in reach with a free vertex; otherwise -1. The
  // first `split` nodes are one feature, the others the second.
  template <class ClosestFunction>
  float distance_if_near(const std::array<int, 4>& nodes, int split,
                         const ClosestFunction& closest) {
    if (std::none_of(nodes.begin(), nodes.end(), [&](int n) { return scene_.is_free(n); }))
      return -1;
    const double path = swept_ ? path_length(nodes) : 0;
    const double reach = reach_ + path;
    if (boxes_apart(nodes, split, reach)) return -1;
    ++counters_.narrow_phase_calls;
    const double squared =
        closest(end_[nodes[0]], end_[nodes[1]], end_[nodes[2]], end_[nodes[3]]).squared_distance;
    if (squared > reach * reach) return -1;
    const double lower = std::max(0.0, std::sqrt(squared) - path);
    return std::max(0.0F, std::nextafter(static_cast<float>(lower), 0.0F));
  }

  // No distance among these nodes changes by more than this along the path.
  double path_length(const std::array<int, 4>& nodes) const {
    double largest = 0;
    for (int n : nodes) largest = std::max(largest, (end_[n] - start_[n]).squaredNorm());
    return 2 * std::sqrt(largest);
  }

  bool boxes_apart(const std::array<int, 4>& nodes, int split, double reach) const {
    for (int axis = 0; axis < 3; ++axis) {
      double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
      for (int i = 0; i < 4; ++i) {
        const int side = i < split ? 0 : 1;
        low[side] = std::min(low[side], end_[nodes[i]][axis]);
        high[side] = std::max(high[side], end_[nodes[i]][axis]);
      }
      if (low[0] - high[1] > reach || low[1] - high[0] > reach) return true;
    }
    return false;
  }

  const Scene& scene_;
  std::span<const Vec3> start_, end_;
  bool swept_;
  double reach_;
  CandidateList& list_;
  Counters& counters_;
  Side a_, b_;
};

}  // namespace

void collect_features(const Scene& scene, std::span<const Vec3> start, std::span<const Vec3> end,
                      std::span<const bsi::LeafPair> quad_pairs, double reach, CandidateList& list,
                      Counters& counters) {
  Collector collector(scene, start, end, reach, list, counters);
  for (const bsi::LeafPair& pair : quad_pairs) collector.add_quads(pair);
  for (auto* features : {&list.vertex_triangle, &list.triangle_vertex, &list.edge_edge}) {
    std::sort(features->begin(), features->end(), [](const FeaturePair& p, const FeaturePair& q) {
      return p.a != q.a ? p.a < q.a : p.b < q.b;
    });
    counters.candidate_pairs += static_cast<std::int64_t>(features->size());
  }
}

}  // namespace weft::sim
