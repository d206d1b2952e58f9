#include "sim/contact/seam_neighbours.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

#include "bsi/proximity.h"

namespace weft::sim {

namespace {

// A number with its distance (m) from a vertex or a place.
struct Near {
  int number = 0;
  double distance = 0;
};

// One side of a stitch: a place on a border, with what lies around it on its surface at rest.
struct StitchSide {
  int body = 0;  // index into Scene::bodies
  std::array<int, 2> nodes{};
  Vec3 place{0, 0, 0};
  double spacing = 0;           // m, largest distance of stitches of its seam
  std::vector<Near> triangles;  // of the body
  std::vector<Near> sides;      // stitch sides of the body
};

// Paths along sewn surfaces at rest. Sides 2 i and 2 i + 1 are those of stitch i.
class SeamPaths {
 public:
  // Finds everything within `reach` (m), and the spacing more, of all stitches.
  SeamPaths(const Scene& scene, double reach) : scene_(scene), reach_(reach) {
    sides_at_.resize(scene.bodies.size());
    sides_near_.resize(scene.bodies.size());
    for (const Seam& seam : scene.seams) add_sides(seam);
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      if (!sides_at_[b].empty()) flood_body(static_cast<int>(b));
    }
  }

  // Calls visit(body, triangle, distance, spacing) for the triangles that paths from a vertex reach
  // across seams. A triangle may be visited several times.
  template <class Visit>
  void visit_beyond(int body, int vertex, const Visit& visit) {
    if (sides_near_[body].empty() || sides_near_[body][vertex].empty()) return;
    cross_seams(sides_near_[body][vertex]);
    for (const int s : reached_) {
      for (const Near& near : sides_[s].triangles)
        visit(sides_[s].body, near.number, distance_[s] + near.distance, sides_[s].spacing);
    }
  }

 private:
  void add_sides(const Seam& seam) {
    double longest = 0;
    for (const Stitch& stitch : seam.stitches) longest = std::max(longest, stitch.length);
    const auto add = [&](int case_body, const std::array<int, 2>& nodes, double weight) {
      StitchSide& side = sides_.emplace_back();
      side.body = scene_.case_order[case_body];
      side.nodes = nodes;
      side.spacing = longest;
      const SceneBody& body = scene_.bodies[side.body];
      const std::vector<Vec3>& rest = body.surface_rest();
      side.place = weight * rest[nodes[0]] + (1 - weight) * rest[nodes[1]];
      auto& at = sides_at_[side.body];
      at.resize(body.point_count());
      sides_near_[side.body].resize(body.point_count());
      const int number = static_cast<int>(sides_.size()) - 1;
      at[nodes[0]].push_back(number);
      if (nodes[1] != nodes[0]) at[nodes[1]].push_back(number);
    };
    for (const Stitch& stitch : seam.stitches) {
      add(seam.body, {stitch.vertex, stitch.vertex}, 1);
      add(seam.to, stitch.nodes, stitch.weight);
    }
    distance_.assign(sides_.size(), infinity);
  }

  void flood_body(int body) {
    const bsi::Mesh& mesh = scene_.bodies[body].surface_mesh();
    std::vector<std::vector<int>> triangles_of(scene_.bodies[body].point_count());
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      for (const int corner : mesh.triangles[t]) triangles_of[corner].push_back(t);
    }
    std::vector<int> seen_triangle(mesh.triangles.size(), -1), seen_vertex(triangles_of.size(), -1);
    for (int s = 0; s < static_cast<int>(sides_.size()); ++s) {
      if (sides_[s].body == body) flood_side(s, triangles_of, seen_triangle, seen_vertex);
    }
  }

  // Finds what is connected with a side inside the ball around it.
  void flood_side(int s, const std::vector<std::vector<int>>& triangles_of,
                  std::vector<int>& seen_triangle, std::vector<int>& seen_vertex) {
    StitchSide& side = sides_[s];
    const std::vector<std::array<int, 3>>& mesh = scene_.bodies[side.body].surface_mesh().triangles;
    const std::vector<Vec3>& rest = scene_.bodies[side.body].surface_rest();
    const double radius = reach_ + side.spacing;
    std::vector<int> vertices;
    const auto reach_vertex = [&](int v) {
      if (std::exchange(seen_vertex[v], s) == s) return;
      vertices.push_back(v);
      const double distance = (rest[v] - side.place).norm();
      if (distance < radius) sides_near_[side.body][v].push_back({s, distance});
      for (const int other : sides_at_[side.body][v]) {
        const double between = (sides_[other].place - side.place).norm();
        if (other != s && between < radius) side.sides.push_back({other, between});
      }
    };
    for (const int node : side.nodes) reach_vertex(node);
    for (std::size_t next = 0; next < vertices.size(); ++next) {
      for (const int t : triangles_of[vertices[next]]) {
        if (std::exchange(seen_triangle[t], s) == s) continue;
        const auto& [a, b, c] = mesh[t];
        const double distance = std::sqrt(
            bsi::closest_vertex_triangle(side.place, rest[a], rest[b], rest[c]).squared_distance);
        if (distance >= radius) continue;
        side.triangles.push_back({t, distance});
        for (const int corner : mesh[t]) reach_vertex(corner);
      }
    }
  }

  // Sets reached_ to the sides at which paths that start at the given ones arrive beyond seams,
  // with the shortest distances in distance_ (Dijkstra's algorithm).
  void cross_seams(const std::vector<Near>& starts) {
    for (const int s : reached_) distance_[s] = infinity;
    reached_.clear();
    const auto later = [](const Near& one, const Near& other) {
      return one.distance > other.distance;
    };
    std::priority_queue<Near, std::vector<Near>, decltype(later)> queue(later);
    const auto arrive = [&](int s, double distance) {
      if (distance >= distance_[s] || distance >= reach_ + sides_[s].spacing) return;
      if (distance_[s] == infinity) reached_.push_back(s);
      distance_[s] = distance;
      queue.push({s, distance});
    };
    for (const Near& start : starts) arrive(start.number ^ 1, start.distance);
    while (!queue.empty()) {
      const Near now = queue.top();
      queue.pop();
      if (now.distance > distance_[now.number]) continue;
      // A side that is sewn to several others lies at a distance of zero from them.
      for (const Near& next : sides_[now.number].sides)
        arrive(next.number ^ 1, now.distance + next.distance);
    }
  }

  static constexpr double infinity = std::numeric_limits<double>::infinity();
  const Scene& scene_;
  double reach_;
  std::vector<StitchSide> sides_;
  // By body and vertex, empty for bodies without seams: the sides that the vertex holds, and the
  // sides in whose ball it is.
  std::vector<std::vector<std::vector<int>>> sides_at_;
  std::vector<std::vector<std::vector<Near>>> sides_near_;
  std::vector<double> distance_;  // m, by side; infinite if not reached
  std::vector<int> reached_;      // sides
};

double mean_thickness(const Scene& scene, int a, int b) {
  return 0.5 * (scene.bodies[a].thickness + scene.bodies[b].thickness);
}

// Returns true if contact leaves out the vertex and the triangle even without neighbourhoods.
bool are_joined(const Scene& scene, int a, int vertex, int b, int triangle) {
  const auto& corners = scene.bodies[b].surface_mesh().triangles[triangle];
  if (a == b && std::ranges::count(corners, vertex) > 0) return true;
  const int first = scene.bodies[b].first_point;
  return scene.sewn.are_joined({scene.bodies[a].first_point + vertex, first + corners[0],
                                first + corners[1], first + corners[2]},
                               1);
}

}  // namespace

std::map<BodyPair, TrianglesByVertex> neighbours_across_seams(const Scene& scene, double range) {
  const auto radius = [&](int a, int b) {
    return std::numbers::pi / 2 * mean_thickness(scene, a, b) + range;
  };
  std::vector<int> bodies;
  for (const Seam& seam : scene.seams)
    for (const int body : {seam.body, seam.to}) bodies.push_back(scene.case_order[body]);
  std::ranges::sort(bodies);
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  double reach = 0;
  for (const int b : bodies) reach = std::max(reach, radius(b, b));
  std::map<BodyPair, TrianglesByVertex> found;
  std::map<BodyPair, bool> is_fine;  // by bodies in ascending order
  SeamPaths paths(scene, reach);
  for (const int a : bodies) {
    for (int v = 0; v < scene.bodies[a].point_count(); ++v) {
      paths.visit_beyond(a, v, [&](int b, int triangle, double distance, double spacing) {
        if (distance >= radius(a, b) + spacing) return;
        TrianglesByVertex& triangles = found[{a, b}];
        triangles.resize(scene.bodies[a].point_count());
        triangles[v].push_back(triangle);
        bool& fine = is_fine[{std::min(a, b), std::max(a, b)}];
        fine = fine || (distance < mean_thickness(scene, a, b) + range &&
                        !are_joined(scene, a, v, b, triangle));
      });
    }
  }
  std::erase_if(found, [&](const auto& entry) {
    const auto& [a, b] = entry.first;
    return !is_fine[{std::min(a, b), std::max(a, b)}];
  });
  for (auto& [pair, all] : found) {
    for (std::vector<int>& triangles : all) {
      std::ranges::sort(triangles);
      triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    }
  }
  return found;
}

}  // namespace weft::sim
