#include "tests/sim/contact_oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bsi/proximity.h"

namespace weft::sim {

namespace {

constexpr double rounding = 1e-12;  // m
constexpr int path_parts = 64;
constexpr double least_share = 0.25;  // share of the start's distance that an accepted path keeps

const std::vector<FeaturePair>& features_of(const CandidateList& list, int kind, bool neighbours) {
  if (neighbours) return kind == 2 ? list.near_edge_edge : list.near_vertex_triangle;
  return kind == 0 ? list.vertex_triangle : kind == 1 ? list.triangle_vertex : list.edge_edge;
}

bool precedes(const FeaturePair& p, const FeaturePair& q) {
  return p.a != q.a ? p.a < q.a : p.b < q.b;
}

double pair_distance(bool edges, const bsi::FourPoints& x) {
  const bsi::Closest closest = edges ? bsi::closest_edge_edge(x[0], x[1], x[2], x[3])
                                     : bsi::closest_vertex_triangle(x[0], x[1], x[2], x[3]);
  return std::sqrt(closest.squared_distance);
}

// Returns the four points at the fraction `t` of their straight paths.
bsi::FourPoints on_path(const OraclePair& pair, std::span<const Vec3> start,
                        std::span<const Vec3> end, double t) {
  bsi::FourPoints points;
  for (std::size_t i = 0; i < 4; ++i)
    points[i] = (1 - t) * start[pair.nodes[i]] + t * end[pair.nodes[i]];
  return points;
}

double longest_path(const OraclePair& pair, std::span<const Vec3> start,
                    std::span<const Vec3> end) {
  double longest = 0;
  for (const int node : pair.nodes) longest = std::max(longest, (end[node] - start[node]).norm());
  return longest;
}

std::string words_of(const Scene& scene, const OraclePair& pair) {
  return std::string(pair.edges() ? "the edges at " : "the vertex and the triangle at ") +
         scene.describe_particle(pair.nodes[0]) + " and " + scene.describe_particle(pair.nodes[3]);
}

}  // namespace

double OraclePair::distance(std::span<const Vec3> position) const {
  return pair_distance(edges(), on_path(*this, position, position, 0));
}

ContactOracle::ContactOracle(const Scene& scene)
    : scene_(scene), range_(scene.source.contact.range), searched_(searched_pairs(scene)) {
  for (std::size_t l = 0; l < searched_.size(); ++l) {
    const SceneBody& a = scene.bodies[searched_[l].body_a];
    const SceneBody& b = scene.bodies[searched_[l].body_b];
    neighbourhood_.clear();
    if (searched_[l].is_self()) find_neighbourhoods(a, neighbour_radius(a, range_));
    add_vertices(l, 0, a, b);
    if (!searched_[l].is_self()) add_vertices(l, 1, b, a);
    add_edges(l, a, b);
  }
}

// Finds, for each vertex, the triangles within the radius at rest that triangles of that kind
// connect with the vertex: passes over all triangles, until a pass finds no more.
void ContactOracle::find_neighbourhoods(const SceneBody& body, double radius) {
  const auto& triangles = body.mesh.triangles;
  const int vertices = body.particle_count();
  bool beyond_rings = false;
  neighbourhood_.assign(vertices, std::vector<char>(triangles.size(), 0));
  for (int v = 0; v < vertices; ++v) {
    std::vector<char> reached(vertices, 0);
    reached[v] = 1;
    for (bool grew = true; grew;) {
      grew = false;
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto& [a, b, c] = triangles[t];
        if (neighbourhood_[v][t] != 0 || reached[a] + reached[b] + reached[c] == 0) continue;
        if (pair_distance(false, {body.rest[v], body.rest[a], body.rest[b], body.rest[c]}) >=
            radius * (1 + 1e-9))
          continue;
        beyond_rings |= a != v && b != v && c != v;
        neighbourhood_[v][t] = reached[a] = reached[b] = reached[c] = 1;
        grew = true;
      }
    }
  }
  if (!beyond_rings) neighbourhood_.clear();
}

bool ContactOracle::are_neighbours(const SceneBody& body, const OraclePair& pair) const {
  if (neighbourhood_.empty()) return false;
  if (!pair.edges()) return neighbourhood_[pair.a][pair.b] != 0;
  const auto holds = [&](int vertex, const bsi::Edge& edge) {
    return std::ranges::all_of(edge.triangle,
                               [&](int t) { return t < 0 || neighbourhood_[vertex][t] != 0; });
  };
  const bsi::Edge &one = body.mesh.edges[pair.a], &other = body.mesh.edges[pair.b];
  return std::ranges::any_of(one.vertex, [&](int v) { return holds(v, other); }) ||
         std::ranges::any_of(other.vertex, [&](int v) { return holds(v, one); });
}

void ContactOracle::add_vertices(std::size_t list, int kind, const SceneBody& vertices,
                                 const SceneBody& triangles) {
  for (int v = 0; v < vertices.particle_count(); ++v) {
    for (std::size_t t = 0; t < triangles.mesh.triangles.size(); ++t) {
      const auto& corners = triangles.mesh.triangles[t];
      const int first = triangles.first_particle;
      add({list,
           kind,
           v,
           static_cast<int>(t),
           {v + vertices.first_particle, corners[0] + first, corners[1] + first,
            corners[2] + first}});
    }
  }
}

void ContactOracle::add_edges(std::size_t list, const SceneBody& first, const SceneBody& second) {
  const bool self = searched_[list].is_self();
  for (std::size_t e = 0; e < first.mesh.edges.size(); ++e) {
    for (std::size_t f = self ? e + 1 : 0; f < second.mesh.edges.size(); ++f) {
      const auto& one = first.mesh.edges[e].vertex;
      const auto& other = second.mesh.edges[f].vertex;
      add({list,
           2,
           static_cast<int>(e),
           static_cast<int>(f),
           {one[0] + first.first_particle, one[1] + first.first_particle,
            other[0] + second.first_particle, other[1] + second.first_particle}});
    }
  }
}

void ContactOracle::add(const OraclePair& pair) {
  const auto& nodes = pair.nodes;
  const auto* second = nodes.begin() + (pair.edges() ? 2 : 1);
  const bool shares = std::any_of(nodes.begin(), second, [&](int node) {
    return std::find(second, nodes.end(), node) != nodes.end();
  });
  const bool free =
      std::any_of(nodes.begin(), nodes.end(), [&](int node) { return scene_.is_free(node); });
  if (shares || !free) return;
  pairs_.push_back(pair);
  OraclePair& added = pairs_.back();
  added.neighbours = searched_[pair.list].is_self() &&
                     are_neighbours(scene_.bodies[searched_[pair.list].body_a], pair);
  added.thickness = added.neighbours ? 0 : searched_[pair.list].thickness;
}

std::vector<OraclePair> ContactOracle::in_reach(std::span<const Vec3> position) const {
  std::vector<OraclePair> found;
  for (const OraclePair& pair : pairs_)
    if (!pair.neighbours && pair.distance(position) < pair.thickness + range_of(pair))
      found.push_back(pair);
  return found;
}

// Vertices of dynamic bodies are samples; other pairs have a shorter range.
double ContactOracle::range_of(const OraclePair& pair) const {
  const CandidateList& bodies = searched_[pair.list];
  const int body = pair.kind == 0 ? bodies.body_a : bodies.body_b;
  return !pair.edges() && scene_.bodies[body].dynamic ? range_ : short_range * range_;
}

std::string ContactOracle::missing(std::span<const CandidateList> lists,
                                   std::span<const Vec3> position) const {
  const auto in_order = [](const FeaturePair& p, const FeaturePair& q) { return !precedes(p, q); };
  for (const CandidateList& list : lists) {
    for (int kind = 0; kind < 3; ++kind) {
      for (const bool neighbours : {false, true}) {
        const auto& features = features_of(list, kind, neighbours);
        if (std::adjacent_find(features.begin(), features.end(), in_order) != features.end())
          return "a list is not sorted, or holds a pair twice";
      }
    }
  }
  std::vector<OraclePair> wanted_pairs = in_reach(position);
  for (const OraclePair& pair : pairs_)
    if (pair.neighbours && pair.distance(position) <= 0) wanted_pairs.push_back(pair);
  for (const OraclePair& pair : wanted_pairs) {
    const CandidateList& bodies = searched_[pair.list];
    const auto list = std::ranges::find_if(lists, [&](const CandidateList& one) {
      return one.body_a == bodies.body_a && one.body_b == bodies.body_b;
    });
    if (list == lists.end()) return words_of(scene_, pair) + " are of bodies without a list";
    const auto& features = features_of(*list, pair.kind, pair.neighbours);
    const FeaturePair wanted{pair.a, pair.b, 0};
    const auto found = std::lower_bound(features.begin(), features.end(), wanted, precedes);
    if (found == features.end() || precedes(wanted, *found))
      return words_of(scene_, pair) + " are not listed";
    if (found->distance - list->drift > pair.distance(position) + rounding)
      return words_of(scene_, pair) + " are closer than their list says";
  }
  return "";
}

double ContactOracle::smallest_gap(std::span<const Vec3> position) const {
  double least = std::numeric_limits<double>::infinity();
  for (const OraclePair& pair : pairs_) {
    if (!pair.neighbours) least = std::min(least, pair.distance(position) - pair.thickness);
  }
  return least;
}

PathDistances ContactOracle::distances(const OraclePair& pair, std::span<const Vec3> start,
                                       std::span<const Vec3> end) {
  PathDistances result;
  result.least = std::numeric_limits<double>::infinity();
  for (int part = 0; part <= path_parts; ++part) {
    const double t = static_cast<double>(part) / path_parts;
    const double distance = pair_distance(pair.edges(), on_path(pair, start, end, t));
    if (part == 0) result.start = distance;
    result.end = distance;
    result.least = std::min(result.least, distance);
  }
  // Within half a part of the nearest sample, both sides may approach.
  result.uncertainty = longest_path(pair, start, end) / path_parts;
  return result;
}

std::optional<ContactOracle::Verdict> ContactOracle::verdict(std::span<const Vec3> start,
                                                             std::span<const Vec3> end) const {
  bool accepted = true;
  for (const OraclePair& pair : pairs_) {
    const double kept = 0.5 * pair.thickness;
    const double first = pair.distance(start), nearest = first - 2 * longest_path(pair, start, end);
    if (nearest > pair.thickness && nearest - kept >= least_share * (first - kept)) continue;
    const PathDistances path = distances(pair, start, end);
    if (path.end <= pair.thickness - rounding || path.least <= kept - rounding)
      return Verdict::refused;
    const bool ends_well = path.end > pair.thickness + rounding;
    if (!ends_well || path.least - path.uncertainty - kept < least_share * (path.start - kept))
      accepted = false;
  }
  return accepted ? std::optional(Verdict::accepted) : std::nullopt;
}

}  // namespace weft::sim
