// Distances of vertex-triangle and edge-edge pairs, one pair per lane. The length of any separation
// vector is an upper bound of the distance. The gap between the projections (shadows) of both
// features on the line of the vector is a lower bound (docs/theory.md, "The narrow phase").
#include "bsi/kernels/feature_kernels.h"

#include "bsi/kernels/nearest_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

enum Kind { vertex_triangle, edge_edge };

// The four points of each pair, relative to the first point.
template <class V>
struct Points {
  Lanes3<V> x[4];
};

template <class Float>
WEFT_INLINE Lanes<Float> inverse_square(const Lanes3<Lanes<Float>>& a) {
  return 1 / larger(dot(a, a), Lanes<Float>{} + RoundingOf<Float>::smallest_square);
}

template <class Float>
WEFT_INLINE Nearest<Lanes<Float>> nearest_edges(const Lanes3<Lanes<Float>> (&x)[4]) {
  using V = Lanes<Float>;
  const Lanes3<V> first = x[1] - x[0], second = x[3] - x[2], start = x[0] - x[2];
  const V square1 = dot(first, first), square2 = dot(second, second), both = dot(first, second);
  const V along1 = dot(first, start), along2 = dot(second, start);
  const V guess =
      clamped_to_unit((both * along2 - along1 * square2) / (square1 * square2 - both * both));
  const V t = clamped_to_unit((both * guess + along2) * inverse_square<Float>(second));
  const V s = clamped_to_unit((both * t - along1) * inverse_square<Float>(first));
  const Lanes3<V> vector = start + s * first - t * second;
  return {dot(vector, vector), vector};
}

template <class Float>
WEFT_INLINE Nearest<Lanes<Float>> nearest_in_triangle(const Lanes3<Lanes<Float>> (&x)[4]) {
  using V = Lanes<Float>;
  const Lanes3<V> edge1 = x[2] - x[1], edge2 = x[3] - x[1], from = x[0] - x[1];
  const Lanes3<V> normal = cross(edge1, edge2);
  const V inverse = inverse_square<Float>(normal);
  const V weight1 = inverse * dot(cross(edge2, normal), from);
  const V weight2 = inverse * dot(cross(normal, edge1), from);
  const V inside = smallest(weight1, weight2, 1 - (weight1 + weight2));
  const Lanes3<V> to_foot = from - weight1 * edge1 - weight2 * edge2;
  Nearest<V> nearest{dot(from, from), from};
  nearest.offer(inside > 0 ? dot(to_foot, to_foot) : nearest.squared, to_foot);
  const auto offer_edge = [&](const Lanes3<V>& from_start, const Lanes3<V>& edge) {
    const V along = clamped_to_unit(dot(from_start, edge) * inverse_square<Float>(edge));
    const Lanes3<V> vector = from_start - along * edge;
    nearest.offer(dot(vector, vector), vector);
  };
  offer_edge(from, edge1);
  offer_edge(from, edge2);
  offer_edge(x[0] - x[2], x[3] - x[2]);
  return nearest;
}

template <Kind kind, class Float>
WEFT_INLINE Nearest<Lanes<Float>> nearest_of(const Lanes3<Lanes<Float>> (&x)[4]) {
  if constexpr (kind == edge_edge) {
    return nearest_edges<Float>(x);
  } else {
    return nearest_in_triangle<Float>(x);
  }
}

// Returns the gap between the projections of both features on the line along `direction`, times the
// length of `direction`.
template <Kind kind, class V>
WEFT_INLINE V shadow_gap(const Lanes3<V> (&x)[4], const Lanes3<V>& direction) {
  V place[4];
  for (int i = 0; i < 4; ++i) place[i] = dot(direction, x[i]);
  if constexpr (kind == edge_edge) {
    return smaller(place[0], place[1]) - larger(place[2], place[3]);
  } else {
    return place[0] - largest(place[1], place[2], place[3]);
  }
}

template <class V>
WEFT_INLINE V squared_size(const Lanes3<V> (&x)[4]) {
  return largest(dot(x[1], x[1]), dot(x[2], x[2]), dot(x[3], x[3]));
}

// The points of pairs, relative to the first point of each pair. The fourth number of a point has
// no meaning.
template <class Float>
struct Staged {
  static constexpr int chunk = 64;
  alignas(64) Float point[4][chunk][4];

  WEFT_INLINE void fill(const FeatureBatch& batch, const double* positions, int first, int count) {
    for (int k = 0; k < count; ++k) {
      const int* particle = batch.particles[first + k];
      const double* origin = positions + 3L * particle[0];
      for (int i = 0; i < 4; ++i) store_point(positions + 3L * particle[i], origin, point[i][k]);
    }
    for (int k = count; k % lane_count<Float> != 0; ++k) {
      for (auto& points : point)
        for (int axis = 0; axis < 4; ++axis) points[k][axis] = points[count - 1][axis];
    }
  }

  WEFT_INLINE Points<Lanes<Float>> load(int first) const {
    using V = Lanes<Float>;
    Points<V> points;
    for (int i = 0; i < 4; ++i) points.x[i] = load_points(point[i] + first);
    return points;
  }
};

// Calls stage(first, count) for each chunk: `count` pairs, beginning with pair `first`. Then calls
// body(first, k, count) for each vector of the chunk: `count` pairs, beginning with pair first + k.
template <class Float, class Stage, class Body>
WEFT_INLINE void for_lanes(int pairs, const Stage& stage, const Body& body) {
  constexpr int chunk = Staged<Float>::chunk, lanes = lane_count<Float>;
  for (int first = 0; first < pairs; first += chunk) {
    const int count = pairs - first < chunk ? pairs - first : chunk;
    stage(first, count);
    for (int k = 0; k < count; k += lanes) body(first, k, count - k < lanes ? count - k : lanes);
  }
}

template <Kind kind>
void find_apart(const FeatureBatch& batch, float reach, bool* apart) {
  using V = Lanes<float>;
  Staged<float> staged;
  for_lanes<float>(
      batch.count, [&](int first, int count) { staged.fill(batch, batch.positions, first, count); },
      [&](int first, int k, int count) {
        const Points<V> points = staged.load(k);
        const Nearest<V> nearest = nearest_of<kind, float>(points.x);
        const auto result =
            is_apart<float>(shadow_gap<kind>(points.x, nearest.vector), nearest.squared,
                            V{} + reach, safe_size<float>(squared_size(points.x)));
        for (int lane = 0; lane < count; ++lane) apart[first + k + lane] = result[lane] != 0;
      });
}

template <Kind kind>
void measure(const FeatureBatch& batch, double* squared_distance, bool* certain) {
  using V = Lanes<double>;
  Staged<double> staged;
  for_lanes<double>(
      batch.count, [&](int first, int count) { staged.fill(batch, batch.positions, first, count); },
      [&](int first, int k, int count) {
        const Points<V> points = staged.load(k);
        const Nearest<V> nearest = nearest_of<kind, double>(points.x);
        const auto known =
            shadow_gap<kind>(points.x, nearest.vector) >= nearest.squared * (1 - 1e-12);
        for (int lane = 0; lane < count; ++lane) {
          squared_distance[first + k + lane] = nearest.squared[lane];
          certain[first + k + lane] = known[lane] != 0;
        }
      });
}

// Calls body(from, to, k, count) for each vector of pairs at both ends of their paths: `count`
// pairs, beginning with pair k.
template <class Body>
WEFT_INLINE void for_paths(const FeatureBatch& batch, const double* end, const Body& body) {
  Staged<float> staged, staged_end;
  for_lanes<float>(
      batch.count,
      [&](int first, int count) {
        staged.fill(batch, batch.positions, first, count);
        staged_end.fill(batch, end, first, count);
      },
      [&](int first, int k, int count) {
        body(staged.load(k), staged_end.load(k), first + k, count);
      });
}

template <class V>
WEFT_INLINE V size_of_path(const Points<V>& from, const Points<V>& to) {
  return safe_size<float>(larger(squared_size(from.x), squared_size(to.x)));
}

// Works in the frame of each pair's first point. On a fixed line, the gap between projections is
// concave in time, as a minimum of linear functions. The smaller of its values at both ends is
// therefore a lower bound.
template <Kind kind>
void find_safe(const FeatureBatch& batch, const double* end, float separation, float end_separation,
               bool* safe) {
  using V = Lanes<float>;
  for_paths(batch, end, [&](const Points<V>& from, const Points<V>& to, int k, int count) {
    const Nearest<V> nearest = nearest_of<kind, float>(from.x);
    const V size = size_of_path(from, to);
    const auto at_start = is_apart<float>(shadow_gap<kind>(from.x, nearest.vector), nearest.squared,
                                          V{} + separation, size);
    const auto at_end = is_apart<float>(shadow_gap<kind>(to.x, nearest.vector), nearest.squared,
                                        V{} + end_separation, size);
    const auto result = at_start & at_end;
    for (int lane = 0; lane < count; ++lane) safe[k + lane] = result[lane] != 0;
  });
}

// Uses the lines of the shortest vectors at both ends. On each of them, the smaller gap of both
// ends bounds the distance, as above.
template <Kind kind>
void bound_paths(const FeatureBatch& batch, const double* end, float* distance) {
  using V = Lanes<float>;
  for_paths(batch, end, [&](const Points<V>& from, const Points<V>& to, int k, int count) {
    const Nearest<V> shortest[2] = {nearest_of<kind, float>(from.x), nearest_of<kind, float>(to.x)};
    const V size = size_of_path(from, to);
    V bound{};
    for (const Nearest<V>& nearest : shortest) {
      const V gap =
          smaller(shadow_gap<kind>(from.x, nearest.vector), shadow_gap<kind>(to.x, nearest.vector));
      bound = larger(bound, distance_above<float>(gap, nearest.squared, size));
    }
    for (int lane = 0; lane < count; ++lane) distance[k + lane] = bound[lane];
  });
}

}  // namespace

extern const FeatureKernels feature_kernels;
const FeatureKernels feature_kernels{
    {find_apart<vertex_triangle>, find_apart<edge_edge>},
    {measure<vertex_triangle>, measure<edge_edge>},
    {find_safe<vertex_triangle>, find_safe<edge_edge>},
    {bound_paths<vertex_triangle>, bound_paths<edge_edge>},
};

}  // namespace weft::bsi::WEFT_KERNELS
