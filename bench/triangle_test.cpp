#include "bench/triangle_test.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bsi/proximity.h"

namespace weft::bench {

namespace {

using bsi::Vec3;

struct Heights {
  double low,
      high;  // heights of a triangle's corners above a plane, times the length of its normal
};

Heights heights_above(const Vec3& normal, const Vec3& origin, const Triangle& triangle) {
  const double h0 = normal.dot(triangle[0] - origin), h1 = normal.dot(triangle[1] - origin),
               h2 = normal.dot(triangle[2] - origin);
  return {std::min({h0, h1, h2}), std::max({h0, h1, h2})};
}

Vec3 normal_of(const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]); }

bool apart(const Heights& heights, double distance, double normal_length) {
  // The reach is slightly larger than the distance, so that rounding never rejects a near triangle.
  const double reach = distance * normal_length * (1 + 1e-9);
  return heights.low > reach || heights.high < -reach;
}

// True if `b` lies beyond the plane through an edge of `a` that is perpendicular to `a`. This
// separates neighbours in one plane.
bool apart_across_edges(const Triangle& a, const Vec3& normal, const Triangle& b, double distance) {
  for (int k = 0; k < 3; ++k) {
    const Vec3 outward = (a[(k + 1) % 3] - a[k]).cross(normal);
    if (heights_above(outward, a[k], b).low > distance * outward.norm() * (1 + 1e-9)) return true;
  }
  return false;
}

// True if an edge of `a` passes through `b`.
bool pierces(const Triangle& a, const Triangle& b) {
  for (int edge = 0; edge < 3; ++edge) {
    const Vec3 &start = a[edge], &end = a[(edge + 1) % 3];
    const Vec3 along = end - start;
    std::array<double, 3> side{};
    for (int k = 0; k < 3; ++k) side[k] = along.dot((b[k] - start).cross(b[(k + 1) % 3] - start));
    const bool inside = (side[0] >= 0 && side[1] >= 0 && side[2] >= 0) ||
                        (side[0] <= 0 && side[1] <= 0 && side[2] <= 0);
    const Vec3 normal = normal_of(b);
    if (inside && normal.dot(start - b[0]) * normal.dot(end - b[0]) <= 0) return true;
  }
  return false;
}

bool vertices_within(const Triangle& a, const Triangle& b, double squared) {
  return std::any_of(a.begin(), a.end(), [&](const Vec3& vertex) {
    return bsi::closest_vertex_triangle(vertex, b[0], b[1], b[2]).squared_distance <= squared;
  });
}

bool edges_within(const Triangle& a, const Triangle& b, double squared) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double found =
          bsi::closest_edge_edge(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]).squared_distance;
      if (found <= squared) return true;
    }
  }
  return false;
}

}  // namespace

bool triangles_within(const Triangle& a, const Triangle& b, double distance) {
  const Vec3 normal_a = normal_of(a), normal_b = normal_of(b);
  const Heights b_above_a = heights_above(normal_a, a[0], b);
  if (apart(b_above_a, distance, normal_a.norm())) return false;
  const Heights a_above_b = heights_above(normal_b, b[0], a);
  if (apart(a_above_b, distance, normal_b.norm())) return false;
  if (apart_across_edges(a, normal_a, b, distance) || apart_across_edges(b, normal_b, a, distance))
    return false;
  const double squared = distance * distance;
  if (vertices_within(a, b, squared) || vertices_within(b, a, squared)) return true;
  if (edges_within(a, b, squared)) return true;
  const bool planes_cross =
      b_above_a.low <= 0 && b_above_a.high >= 0 && a_above_b.low <= 0 && a_above_b.high >= 0;
  return planes_cross && (pierces(a, b) || pierces(b, a));
}

long count_hits(const TriangleBody& first, const TriangleBody& second,
                std::span<const bsi::LeafPair> pairs, double distance) {
  const auto corners = [](const TriangleBody& body, int t) {
    const auto& [i, j, k] = body.triangles[t];
    return Triangle{body.positions[i], body.positions[j], body.positions[k]};
  };
  long hits = 0;
  for (const auto& [a, b] : pairs) {
    const Triangle other = corners(second, b);
    const bool near =
        first.triangles.empty()
            ? bsi::closest_vertex_triangle(first.positions[a], other[0], other[1], other[2])
                      .squared_distance <= distance * distance
            : triangles_within(corners(first, a), other, distance);
    if (near) ++hits;
  }
  return hits;
}

}  // namespace weft::bench
