#include "bsi/detail/surface_terms.h"

#include <algorithm>

namespace weft::bsi {

namespace {

// Returns the identifier (SurfaceTerm::feature) of the smallest feature (face, edge or vertex) that
// contains the closest point of a triangle. The corners of this feature are those with nonzero
// weights.
int feature_of(const Mesh& mesh, int triangle, const Closest& closest) {
  if (closest.free_directions == 2) return 3 * triangle;
  for (int k = 0; k < 3; ++k) {
    if (closest.free_directions == 1 && closest.weight[k + 1] == 0)
      return 3 * mesh.triangle_edges[triangle][k] + 1;
    if (closest.free_directions == 0 && closest.weight[k + 1] != 0)
      return 3 * mesh.triangles[triangle][k] + 2;
  }
  return 3 * triangle;  // reached only if a weight has underflowed
}

// Returns the point closest to `point` on the edge opposite `corner` of a triangle.
Closest closest_on_edge_opposite(int corner, const Vec3& point, const std::array<Vec3, 3>& x) {
  const int from = (corner + 1) % 3, to = (corner + 2) % 3;
  const Vec3 edge = x[to] - x[from];
  const double along = (point - x[from]).dot(edge), squared_length = edge.squaredNorm();
  const double parameter = along <= 0 ? 0 : along >= squared_length ? 1 : along / squared_length;
  Closest closest;
  closest.weight[0] = 1;
  closest.weight[from + 1] = parameter - 1;
  closest.weight[to + 1] = -parameter;
  closest.separation = parameter < 1 ? Vec3(point - x[from] - parameter * edge) : point - x[to];
  closest.free_directions = parameter > 0 && parameter < 1 ? 1 : 0;
  // As in proximity.cpp, rounding must not turn a short separation towards the edge.
  if (closest.free_directions == 1)
    closest.separation -= (closest.separation.dot(edge) / squared_length) * edge;
  closest.squared_distance = closest.separation.squaredNorm();
  return closest;
}

Closest closest_at_corner(int corner, const Vec3& point, const Vec3& x) {
  Closest closest;
  closest.weight[0] = 1;
  closest.weight[corner + 1] = -1;
  closest.separation = point - x;
  closest.squared_distance = closest.separation.squaredNorm();
  return closest;
}

// Sums the coefficients of the terms of each feature. All terms of a feature have the same closest
// point.
class TermCollector {
 public:
  TermCollector(const Mesh& mesh, double reach, std::vector<SurfaceTerm>& terms)
      : mesh_(mesh), squared_reach_(reach * reach), terms_(terms) {
    terms_.clear();
  }

  void add(int triangle, int coefficient, const Closest& closest) {
    if (!(closest.squared_distance < squared_reach_)) return;
    const int feature = feature_of(mesh_, triangle, closest);
    for (SurfaceTerm& term : terms_) {
      if (term.feature != feature) continue;
      term.coefficient += coefficient;
      return;
    }
    terms_.push_back({feature, triangle, coefficient, closest});
  }

  void drop_what_cancels() {
    std::erase_if(terms_, [](const SurfaceTerm& term) { return term.coefficient == 0; });
  }

 private:
  const Mesh& mesh_;
  double squared_reach_;
  std::vector<SurfaceTerm>& terms_;
};

}  // namespace

SurfaceTerms::SurfaceTerms(const Mesh& mesh, int vertex_count, const Neighbourhoods* neighbourhoods)
    : mesh_(mesh),
      neighbourhoods_(neighbourhoods == nullptr || neighbourhoods->are_rings() ? nullptr
                                                                               : neighbourhoods),
      on_border_(vertex_count, 0),
      neighbour_start_(vertex_count + 1, 0) {
  for (const Edge& edge : mesh.edges) {
    for (int v : edge.vertex) {
      ++neighbour_start_[v + 1];
      if (edge.triangle[1] < 0) on_border_[v] = 1;
    }
  }
  for (int v = 0; v < vertex_count; ++v) neighbour_start_[v + 1] += neighbour_start_[v];
  neighbours_.resize(neighbour_start_.back());
  std::vector<int> next(neighbour_start_.begin(), neighbour_start_.end() - 1);
  for (const Edge& edge : mesh.edges) {
    neighbours_[next[edge.vertex[0]]++] = edge.vertex[1];
    neighbours_[next[edge.vertex[1]]++] = edge.vertex[0];
  }
  for (int v = 0; v < vertex_count; ++v) {
    std::sort(neighbours_.begin() + neighbour_start_[v],
              neighbours_.begin() + neighbour_start_[v + 1]);
  }
  find_own_features();
}

// Finds the features of each triangle that count for points of other surfaces. An inner vertex
// belongs to the first of its triangles.
void SurfaceTerms::find_own_features() {
  own_features_.assign(mesh_.triangles.size(), 0);
  std::vector<char> has_triangle(on_border_.size(), 0);
  for (int t = 0; t < static_cast<int>(mesh_.triangles.size()); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int edge = mesh_.triangle_edges[t][k], corner = mesh_.triangles[t][k];
      const auto& [first, second] = mesh_.edges[edge].triangle;
      if (first == t && second >= 0) own_features_[t] |= 1U << k;
      if (has_triangle[corner] == 0 && on_border_[corner] == 0) own_features_[t] |= 8U << k;
      has_triangle[corner] = 1;
    }
  }
}

bool SurfaceTerms::is_beside(const Edge& edge, int own, const Neighbourhoods* near) const {
  if (near == nullptr) return edge.opposite[0] == own || edge.opposite[1] == own;
  return near->contains(own, edge.triangle[0]) || near->contains(own, edge.triangle[1]);
}

bool SurfaceTerms::is_beside(int vertex, int own, const Neighbourhoods* near) const {
  if (near != nullptr) return near->touches(own, vertex);
  return std::binary_search(neighbours_.begin() + neighbour_start_[vertex],
                            neighbours_.begin() + neighbour_start_[vertex + 1], own);
}

unsigned SurfaceTerms::own_features(int triangle, int own, const Neighbourhoods* across) const {
  unsigned features = own_features_[triangle];
  if (own < 0) return features;
  const Neighbourhoods* const near = across != nullptr ? across : neighbourhoods_;
  for (int k = 0; k < 3; ++k) {
    const Edge& edge = mesh_.edges[mesh_.triangle_edges[triangle][k]];
    const unsigned of_edge = 1U << k, of_corner = 8U << k;
    if ((features & of_edge) != 0 && is_beside(edge, own, near)) features &= ~of_edge;
    if ((features & of_corner) != 0 && is_beside(mesh_.triangles[triangle][k], own, near))
      features &= ~of_corner;
  }
  return features;
}

void SurfaceTerms::find(const Vec3& point, int own, std::span<const int> triangles,
                        std::span<const Vec3> position, double reach,
                        std::vector<SurfaceTerm>& terms, const Neighbourhoods* across) const {
  TermCollector collector(mesh_, reach, terms);
  for (const int t : triangles) {
    const auto& corners = mesh_.triangles[t];
    const std::array<Vec3, 3> x{position[corners[0]], position[corners[1]], position[corners[2]]};
    collector.add(t, 1, closest_vertex_triangle(point, x[0], x[1], x[2]));
    // If an inner edge or vertex is within reach, so are all its triangles, and all are listed. The
    // first of them adds the term of the edge or vertex.
    const unsigned features = own_features(t, own, across);
    for (int k = 0; k < 3; ++k) {
      if ((features >> k & 1U) != 0) collector.add(t, -1, closest_on_edge_opposite(k, point, x));
      if ((features >> k & 8U) != 0) collector.add(t, 1, closest_at_corner(k, point, x[k]));
    }
  }
  collector.drop_what_cancels();
}

}  // namespace weft::bsi
