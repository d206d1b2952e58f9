// Distances of triangles, one pair a lane. What the verdicts rest on is proved in docs/theory.md
// ("The narrow phase"): a separation vector, however it was found, proves an upper bound of the
// distance by its length and a lower one by the shadows of both triangles on its line.
#include "bsi/narrow_phase_kernels.h"

#include "bsi/nearest_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

template <class V>
struct Triangle {
  Lanes3<V> corner[3];
  Lanes3<V> edge[3];  // edge i runs from corner i to the next
  V squared_length[3];
  V inverse[3];  // of the squared length
};

// Pairs in one frame: corner 0 of the first triangle is the origin.
template <class V>
struct Frame {
  Triangle<V> a, b;
  V size;  // no corner is further from the origin
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

// The closest points of all pairs of edges: on two lines, then the best on either for the other,
// each held to its edge. Dot products of neighbouring pairs differ by one of two edges.
template <class V>
WEFT_INLINE void offer_edge_pairs(const Triangle<V>& a, const Triangle<V>& b, Nearest<V>& nearest) {
  V along_b[3];  // b's edge j . (corner i of a - corner j of b)
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

// The corners of one triangle over the inside of the other; its border is the edges' business.
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

// The gap between the shadows of the triangles on the line along `direction`, times its length.
template <class V>
WEFT_INLINE V shadow_gap(const Frame<V>& frame, const Lanes3<V>& direction) {
  const Lanes3<V>* a = frame.a.corner;
  const Lanes3<V>* b = frame.b.corner;
  return smallest(dot(direction, a[0]), dot(direction, a[1]), dot(direction, a[2])) -
         largest(dot(direction, b[0]), dot(direction, b[1]), dot(direction, b[2]));
}

// How far the signs of the volumes that show an edge of `a` to pass through `b` are from 0.
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
struct Staged {
  static constexpr int chunk = 64;
  alignas(64) Float corner[6][chunk][4];
};

template <class Float>
WEFT_INLINE void stage(const TrianglePairs& pairs, int first, int count, Staged<Float>& staged) {
  for (int k = 0; k < count; ++k) {
    const LeafPair pair = pairs.pairs[first + k];
    const int* a = pairs.triangles_a + 3L * pair.a;
    const int* b = pairs.triangles_b + 3L * pair.b;
    const double* origin = pairs.positions_a + 3L * a[0];
    store_point(origin, origin, staged.corner[0][k]);
    store_point(pairs.positions_a + 3L * a[1], origin, staged.corner[1][k]);
    store_point(pairs.positions_a + 3L * a[2], origin, staged.corner[2][k]);
    for (int i = 0; i < 3; ++i)
      store_point(pairs.positions_b + 3L * b[i], origin, staged.corner[3 + i][k]);
  }
  for (int k = count; k % lane_count<Float> != 0; ++k) {
    for (auto& corner : staged.corner)
      for (int axis = 0; axis < 4; ++axis) corner[k][axis] = corner[count - 1][axis];
  }
}

template <class Float>
WEFT_INLINE Frame<Lanes<Float>> load_frame(const Staged<Float>& staged, int first) {
  using V = Lanes<Float>;
  Frame<V> frame;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    frame.a.corner[i] = load_points(staged.corner[i] + first);
    frame.b.corner[i] = load_points(staged.corner[3 + i] + first);
  }
  set_edges<Float>(frame.a);
  set_edges<Float>(frame.b);
  const Lanes3<V>* b = frame.b.corner;
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

constexpr double volume_rounding = 2048;  // units, for the volumes of piercing()

// 0, 1 or 2 as in Verdict.
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

void judge(const TrianglePairs& pairs, float margin_low, float margin_high, Verdict* verdict) {
  constexpr int chunk = Staged<float>::chunk, lanes = lane_count<float>;
  Staged<float> staged;
  for (int first = 0; first < pairs.count; first += chunk) {
    const int count = pairs.count - first < chunk ? pairs.count - first : chunk;
    stage(pairs, first, count, staged);
    for (int k = 0; k < count; k += lanes) {
      const auto frame = load_frame(staged, k);
      const auto nearest = nearest_points<float>(frame);
      const auto result = verdict_of(frame, nearest, margin_low, margin_high);
      const int known = count - k < lanes ? count - k : lanes;
      for (int lane = 0; lane < known; ++lane)
        verdict[first + k + lane] = static_cast<Verdict>(static_cast<int>(result[lane]));
    }
  }
}

void measure(const TrianglePairs& pairs, double margin, Verdict* verdict, double* squared_distance,
             bool* certain) {
  constexpr int chunk = Staged<double>::chunk, lanes = lane_count<double>;
  using V = Lanes<double>;
  Staged<double> staged;
  for (int first = 0; first < pairs.count; first += chunk) {
    const int count = pairs.count - first < chunk ? pairs.count - first : chunk;
    stage(pairs, first, count, staged);
    for (int k = 0; k < count; k += lanes) {
      const auto frame = load_frame(staged, k);
      const auto nearest = nearest_points<double>(frame);
      const V size = frame.size;
      const auto pierced =
          piercing(frame) > volume_rounding * RoundingOf<double>::unit * size * size * size;
      const V gap = shadow_gap(frame, nearest.vector);
      const V squared = pierced ? V{} : nearest.squared;
      const V known = pierced || gap >= nearest.squared * (1 - 1e-12) ? V{} + 1 : V{};
      const V result = pierced ? V{} + 1 : verdict_of(frame, nearest, margin, margin);
      const int used = count - k < lanes ? count - k : lanes;
      for (int lane = 0; lane < used; ++lane) {
        verdict[first + k + lane] = static_cast<Verdict>(static_cast<int>(result[lane]));
        squared_distance[first + k + lane] = squared[lane];
        certain[first + k + lane] = known[lane] != 0;
      }
    }
  }
}

}  // namespace

extern const NarrowPhaseKernels narrow_phase_kernels;
const NarrowPhaseKernels narrow_phase_kernels{judge, measure};

}  // namespace weft::bsi::WEFT_KERNELS
