// Distances of triangles, one pair per lane. The length of any separation vector is an upper bound
// of the distance. The gap between the projections (shadows) of both triangles on the line of the
// vector is a lower bound. Verdicts are proved from both (docs/theory.md, "The narrow phase"). For
// kernel files only, like lanes.h.
#pragma once

#include "bsi/kernels/nearest_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

template <class V>
struct Triangle {
  Lanes3<V> corner[3];
  Lanes3<V> edge[3];  // edge i runs from corner i to corner i + 1 (mod 3)
  V squared_length[3];
  V inverse[3];  // reciprocals of squared_length
};

// Pairs of triangles, one per lane, relative to corner 0 of the first triangle.
template <class V>
struct Frame {
  Triangle<V> a, b;
  V size;  // largest distance of a corner from the origin, m (see safe_size())
};

template <class Float>
WEFT_INLINE void set_edges(Triangle<Lanes<Float>>& triangle) {
  using V = Lanes<Float>;
  const V least = V{} + RoundingOf<Float>::smallest_square;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    triangle.edge[i] = triangle.corner[(i + 1) % 3] - triangle.corner[i];
    triangle.squared_length[i] = dot(triangle.edge[i], triangle.edge[i]);
    triangle.inverse[i] = 1 / larger(triangle.squared_length[i], least);
  }
}

// Offers the vector between the closest points of every pair of edges. The first step finds the
// point of a's edge closest to the line of b's edge, the second the point of b's edge closest to
// the first point. The third step finds the point of a's edge closest to the second point. Each
// point is clamped to its edge. The dot products of consecutive pairs of edges differ by a dot
// product of two edges.
template <class V>
WEFT_INLINE void offer_edge_pairs(const Triangle<V>& a, const Triangle<V>& b, Nearest<V>& nearest) {
  V along_b[3];  // dot product of b's edge j and (a's corner i - b's corner j)
#pragma GCC unroll 3
  for (int j = 0; j < 3; ++j) along_b[j] = dot(b.edge[j], a.corner[0] - b.corner[j]);
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    V along_a = dot(a.edge[i], a.corner[i] - b.corner[0]);
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const V both = dot(a.edge[i], b.edge[j]);
      const V scale = a.squared_length[i] * b.squared_length[j] - both * both;
      const V first = (both * along_b[j] - along_a * b.squared_length[j]) / scale;
      const V t = clamped_to_unit((both * clamped_to_unit(first) + along_b[j]) * b.inverse[j]);
      const V s = clamped_to_unit((both * t - along_a) * a.inverse[i]);
      const Lanes3<V> vector = a.corner[i] - b.corner[j] + s * a.edge[i] - t * b.edge[j];
      nearest.offer(dot(vector, vector), vector);
      along_a -= both;
      along_b[j] += both;
    }
  }
}

// Offers the vectors between the corners of one triangle and their projections, if these lie inside
// the other triangle. The border of the triangle is left to offer_edge_pairs().
template <bool corners_of_a, class Float>
WEFT_INLINE void offer_corners(const Triangle<Lanes<Float>>& corners,
                               const Triangle<Lanes<Float>>& triangle,
                               Nearest<Lanes<Float>>& nearest) {
  using V = Lanes<Float>;
  const Lanes3<V> edge1 = triangle.edge[0], edge2 = -triangle.edge[2];
  const Lanes3<V> normal = cross(edge1, edge2);
  const V inverse = 1 / larger(dot(normal, normal), V{} + RoundingOf<Float>::smallest_square);
  const Lanes3<V> slope1 = inverse * cross(edge2, normal);
  const Lanes3<V> slope2 = inverse * cross(normal, edge1);
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const Lanes3<V> from = corners.corner[i] - triangle.corner[0];
    const V weight1 = dot(slope1, from), weight2 = dot(slope2, from);
    const V least = smaller(smaller(weight1, weight2), 1 - (weight1 + weight2));
    const Lanes3<V> foot = weight1 * edge1 + weight2 * edge2;
    const Lanes3<V> vector = corners_of_a ? from - foot : foot - from;
    const V squared = dot(vector, vector);
    nearest.offer(least > 0 ? squared : nearest.squared, vector);
  }
}

// Returns the gap between the projections of both triangles on the line along `direction`, times
// the length of `direction`.
template <class V>
WEFT_INLINE V shadow_gap(const Frame<V>& frame, const Lanes3<V>& direction) {
  const Lanes3<V>* a = frame.a.corner;
  const Lanes3<V>* b = frame.b.corner;
  return smallest(dot(direction, a[0]), dot(direction, a[1]), dot(direction, a[2])) -
         largest(dot(direction, b[0]), dot(direction, b[1]), dot(direction, b[2]));
}

// Returns a positive number if an edge of `a` passes through `b`, else a number that is not
// positive. The signs of volumes decide. For an edge that passes through, the smallest magnitude of
// its volumes counts. The result is the largest such number of all edges.
template <class V>
WEFT_INLINE V piercing(const Triangle<V>& a, const Triangle<V>& b, const V (&volume)[3][3]) {
  const Lanes3<V> normal = cross(b.edge[0], b.edge[1]);
  V height[3];
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) height[i] = dot(normal, a.corner[i] - b.corner[0]);
  V best = V{} - 1;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const V from = height[i], to = height[(i + 1) % 3];
    const V across = larger(smaller(from, -to), smaller(-from, to));
    const V* v = volume[i];
    const V inside = larger(smallest(v[0], v[1], v[2]), -largest(v[0], v[1], v[2]));
    best = larger(best, smaller(across, inside));
  }
  return best;
}

template <class V>
WEFT_INLINE V piercing(const Frame<V>& frame) {
  V volume[3][3], transposed[3][3];
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      volume[i][j] =
          dot(cross(frame.a.edge[i], frame.b.edge[j]), frame.a.corner[i] - frame.b.corner[j]);
      transposed[j][i] = volume[i][j];
    }
  }
  return larger(piercing(frame.a, frame.b, volume), piercing(frame.b, frame.a, transposed));
}

template <class Float>
WEFT_INLINE Frame<Lanes<Float>> frame_of(const Lanes3<Lanes<Float>> (&a)[3],
                                         const Lanes3<Lanes<Float>> (&b)[3]) {
  using V = Lanes<Float>;
  Frame<V> frame;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    frame.a.corner[i] = a[i];
    frame.b.corner[i] = b[i];
  }
  set_edges<Float>(frame.a);
  set_edges<Float>(frame.b);
  const V squared_size = larger(larger(frame.a.squared_length[0], frame.a.squared_length[2]),
                                largest(dot(b[0], b[0]), dot(b[1], b[1]), dot(b[2], b[2])));
  frame.size = safe_size<Float>(squared_size);
  return frame;
}

template <class Float>
WEFT_INLINE Nearest<Lanes<Float>> nearest_points(const Frame<Lanes<Float>>& frame) {
  using V = Lanes<Float>;
  const Lanes3<V> start = frame.a.corner[0] - frame.b.corner[0];
  Nearest<V> nearest{dot(start, start), start};
  offer_edge_pairs(frame.a, frame.b, nearest);
  offer_corners<true, Float>(frame.a, frame.b, nearest);
  offer_corners<false, Float>(frame.b, frame.a, nearest);
  return nearest;
}

// Returns the verdict of each lane as 0, 1 or 2, the values of Verdict.
template <class Float>
WEFT_INLINE Lanes<Float> verdict_of(const Frame<Lanes<Float>>& frame,
                                    const Nearest<Lanes<Float>>& nearest, Float margin_low,
                                    Float margin_high) {
  using V = Lanes<Float>;
  constexpr Float least = RoundingOf<Float>::smallest_square;
  const V reach = larger(margin_low - Bounds<Float>::length * frame.size, V{});
  const auto apart = is_apart<Float>(shadow_gap(frame, nearest.vector), nearest.squared,
                                     V{} + margin_high, frame.size);
  const V not_near = apart ? V{} : V{} + 2;
  return nearest.squared * Bounds<Float>::relative + least <= reach * reach ? V{} + 1 : not_near;
}

// Decides most pairs of triangles without comparing edges with edges. The distance is at most that
// of a corner from a point of the other triangle near the corner's projection. If all three corners
// lie on one side of the other triangle's plane, the distance is at least their smallest distance
// from that plane. The same holds for a plane through an edge, perpendicular to the triangle,
// beyond which all three corners lie.
struct Sieve {
  using V = Lanes<float>;
  V squared;  // smallest upper bound of the squared distance so far
  V beyond;   // positive if a plane proves the distance larger than the margin

  // Compares the corners of one triangle with the other triangle. `squared_margin` is slightly
  // above the square of the margin.
  WEFT_INLINE void sift(const Lanes3<V>* corner, const Lanes3<V>* triangle, V squared_size,
                        float squared_margin) {
    const Lanes3<V> edge1 = triangle[1] - triangle[0], edge2 = triangle[2] - triangle[0];
    const Lanes3<V> normal = cross(edge1, edge2);
    const V inverse = 1 / larger(dot(normal, normal), V{} + RoundingOf<float>::smallest_square);
    const Lanes3<V> slope1 = inverse * cross(edge2, normal);
    const Lanes3<V> slope2 = inverse * cross(normal, edge1);
    V weight0[3], weight1[3], weight2[3], height[3];
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
      const Lanes3<V> from = corner[i] - triangle[0];
      weight1[i] = dot(slope1, from);
      weight2[i] = dot(slope2, from);
      weight0[i] = 1 - (weight1[i] + weight2[i]);
      height[i] = dot(normal, from);
      const V near1 = clamped_to_unit(weight1[i]);
      const V near2 = larger(smaller(weight2[i], 1 - near1), V{});
      const Lanes3<V> vector = from - near1 * edge1 - near2 * edge2;
      squared = smaller(dot(vector, vector), squared);
    }
    const V scale = inverse * squared_margin;
    const V rounding = (inverse * squared_size) * squared_size;
    const auto offer_edge = [&](const V(&weight)[3], const Lanes3<V>& edge) {
      const V across = larger(-largest(weight[0], weight[1], weight[2]), V{});
      const V limit = scale * dot(edge, edge) + edge_rounding * rounding;
      beyond = larger(across * across - limit, beyond);
    };
    offer_edge(weight0, edge2 - edge1);
    offer_edge(weight1, edge2);
    offer_edge(weight2, edge1);
    const V above = larger(larger(smallest(height[0], height[1], height[2]),
                                  -largest(height[0], height[1], height[2])),
                           V{});
    const V limit = squared_margin + (plane_rounding * rounding) * squared_size;
    beyond = larger((above * inverse) * above - limit, beyond);
  }

  // Rounding allowances in squared distances (docs/theory.md, "The narrow phase").
  static constexpr float edge_rounding = 0x1p-21F, plane_rounding = 0x1p-24F;
};

// Returns the verdict of each lane as 0, 1 or 2, the values of Verdict. Corner 0 of the first
// triangle must be the origin.
WEFT_INLINE Lanes<float> sifted(const Lanes3<Lanes<float>> (&a)[3],
                                const Lanes3<Lanes<float>> (&b)[3], float margin_low,
                                float margin_high) {
  using V = Lanes<float>;
  constexpr float least = RoundingOf<float>::smallest_square;
  const V squared_size = larger(larger(dot(a[1], a[1]), dot(a[2], a[2])),
                                largest(dot(b[0], b[0]), dot(b[1], b[1]), dot(b[2], b[2])));
  const float squared_margin = margin_high * margin_high * (1 + 0x1p-9F) + least;
  Sieve sieve{dot(b[0], b[0]), V{}};
  sieve.sift(a, b, squared_size, squared_margin);
  sieve.sift(b, a, squared_size, squared_margin);
  const V reach = larger(margin_low - Bounds<float>::length * safe_size<float>(squared_size), V{});
  const V not_near = sieve.beyond > V{} ? V{} : V{} + 2;
  return sieve.squared * Bounds<float>::relative + least <= reach * reach ? V{} + 1 : not_near;
}

}  // namespace weft::bsi::WEFT_KERNELS
