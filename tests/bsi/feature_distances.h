// The vertices, edges and triangles of an atlas and their distances, pair by pair in float64: the
// oracle of traversals.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "bsi/proximity.h"

namespace weft::bsi {

using Positions = std::vector<Vec3>;

// A vertex, an edge or a triangle, with the triangles that contain it.
struct Feature {
  std::vector<int> vertices;
  std::vector<int> triangles;
};

inline std::vector<Feature> features_of(const Atlas& atlas) {
  std::map<std::vector<int>, std::vector<int>> holders;
  for (int t = 0; t < 2 * atlas.quad_count(); ++t) {
    auto corner = quad_triangles(atlas.quad_particles(t / 2))[t % 2];
    std::ranges::sort(corner);
    const auto [a, b, c] = corner;
    for (const std::vector<int>& feature :
         std::vector<std::vector<int>>{{a}, {b}, {c}, {a, b}, {b, c}, {a, c}, {a, b, c}}) {
      holders[feature].push_back(t);
    }
  }
  std::vector<Feature> features;
  features.reserve(holders.size());
  for (auto& [vertices, triangles] : holders) features.push_back({vertices, triangles});
  return features;
}

inline bool share_a_vertex(const std::vector<int>& a, const std::vector<int>& b) {
  return std::ranges::find_first_of(a, b) != a.end();
}

// Two features without a common vertex, of kinds whose distances make up that of two triangles: a
// vertex and a triangle, two edges, or an edge and a triangle, which the edge may pierce.
struct FeaturePair {
  const Feature* a;
  const Feature* b;
};

inline std::vector<FeaturePair> pairs_of_features(const std::vector<Feature>& features) {
  std::vector<FeaturePair> pairs;
  for (const Feature& a : features) {
    for (const Feature& b : features) {
      const std::size_t of_a = a.vertices.size(), of_b = b.vertices.size();
      const bool wanted = (of_a == 1 && of_b == 3) || (of_a == 2 && of_b == 2 && &a < &b) ||
                          (of_a == 2 && of_b == 3);
      if (wanted && !share_a_vertex(a.vertices, b.vertices)) pairs.push_back({&a, &b});
    }
  }
  return pairs;
}

inline FourPoints points_of(const FeaturePair& pair, const Positions& x) {
  FourPoints points;
  int next = 0;
  for (const int vertex : pair.a->vertices) points[next++] = x[vertex];
  for (const int vertex : pair.b->vertices) points[next++] = x[vertex];
  return points;
}

// Returns the sign of u . (v x w), or 0 if rounding might have decided it.
inline int orientation(const Vec3& u, const Vec3& v, const Vec3& w) {
  const double value = u.dot(v.cross(w));
  if (std::abs(value) <= 1e-14 * u.norm() * v.norm() * w.norm()) return 0;
  return value > 0 ? 1 : -1;
}

// True only if the edge certainly pierces the triangle.
inline bool pierces(const FeaturePair& pair, const Positions& x) {
  const Vec3 &from = x[pair.a->vertices[0]], &to = x[pair.a->vertices[1]];
  const Vec3 &p = x[pair.b->vertices[0]], &q = x[pair.b->vertices[1]], &r = x[pair.b->vertices[2]];
  const int before = orientation(from - p, q - p, r - p);
  if (before == 0 || orientation(to - p, q - p, r - p) != -before) return false;
  const Vec3 along = to - from;
  const int side = orientation(along, p - from, q - from);
  return side != 0 && orientation(along, q - from, r - from) == side &&
         orientation(along, r - from, p - from) == side;
}

inline constexpr double infinity = std::numeric_limits<double>::infinity();

inline double distance(const FeaturePair& pair, const Positions& x) {
  if (pair.a->vertices.size() + pair.b->vertices.size() == 5)
    return pierces(pair, x) ? 0 : infinity;
  const FourPoints p = points_of(pair, x);
  const Closest closest = pair.a->vertices.size() == 1
                              ? closest_vertex_triangle(p[0], p[1], p[2], p[3])
                              : closest_edge_edge(p[0], p[1], p[2], p[3]);
  return std::sqrt(closest.squared_distance);
}

inline Positions between(const Positions& start, const Positions& end, double t) {
  Positions x(start.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = (1 - t) * start[i] + t * end[i];
  return x;
}

}  // namespace weft::bsi
