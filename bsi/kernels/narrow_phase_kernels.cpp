// Judges and measures the triangle pairs of a list, one pair per lane (see triangle_lanes.h).
#include "bsi/kernels/narrow_phase_kernels.h"

#include "bsi/kernels/triangle_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

constexpr int chunk = 64;  // pairs per chunk, a multiple of all lane counts

// The corners of pairs of triangles, relative to corner 0 of the first triangle: two corners of the
// first triangle, then the three corners of the second.
template <class Float, int capacity = chunk>
struct Staged {
  alignas(64) Float corner[5][capacity][4];

  WEFT_INLINE void fill(const TrianglePairs& pairs, int first, int count) {
    for (int k = 0; k < count; ++k) {
      const LeafPair pair = pairs.pairs[first + k];
      const int* a = pairs.triangles_a + 3L * pair.a;
      const int* b = pairs.triangles_b + 3L * pair.b;
      const double* origin = pairs.positions_a + 3L * a[0];
      store_point(pairs.positions_a + 3L * a[1], origin, corner[0][k]);
      store_point(pairs.positions_a + 3L * a[2], origin, corner[1][k]);
      for (int i = 0; i < 3; ++i)
        store_point(pairs.positions_b + 3L * b[i], origin, corner[2 + i][k]);
    }
    pad(count);
  }
  // Repeats the last pair to fill the last vector.
  WEFT_INLINE void pad(int count) {
    for (int k = count; k % lane_count<Float> != 0; ++k) copy(*this, count - 1, k);
  }
  template <int other_capacity>
  WEFT_INLINE void copy(const Staged<Float, other_capacity>& from, int pair, int to) {
    typedef Float Float4 __attribute__((vector_size(4 * sizeof(Float))));
    for (int i = 0; i < 5; ++i) {
      *reinterpret_cast<Float4*>(corner[i][to]) =
          *reinterpret_cast<const Float4*>(from.corner[i][pair]);
    }
  }
};

template <class Float, int capacity>
WEFT_INLINE void load_corners(const Staged<Float, capacity>& staged, int first,
                              Lanes3<Lanes<Float>> (&a)[3], Lanes3<Lanes<Float>> (&b)[3]) {
  a[0] = Lanes3<Lanes<Float>>{};
  a[1] = load_points(staged.corner[0] + first);
  a[2] = load_points(staged.corner[1] + first);
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) b[i] = load_points(staged.corner[2 + i] + first);
}

template <class Float, int capacity>
WEFT_INLINE Frame<Lanes<Float>> load_frame(const Staged<Float, capacity>& staged, int first) {
  Lanes3<Lanes<Float>> a[3], b[3];
  load_corners(staged, first, a, b);
  return frame_of<Float>(a, b);
}

// Upper bound of the rounding errors of the volumes that piercing() computes, in units of u size^3.
// u is RoundingOf<double>::unit, and size is Frame::size.
constexpr double volume_rounding = 2048;

WEFT_INLINE Verdict to_verdict(float number) {
  return static_cast<Verdict>(static_cast<unsigned char>(number));
}

// Decides most pairs by the cheap tests of sifted(). The undecided pairs are packed into full
// vectors, and their distances are computed.
void judge(const TrianglePairs& pairs, float margin_low, float margin_high, Verdict* verdict) {
  constexpr int lanes = lane_count<float>;
  Staged<float> staged;
  Staged<float, 2 * chunk> open;
  int place[2 * chunk];
  int open_count = 0;
  for (int first = 0; first < pairs.count; first += chunk) {
    const int count = pairs.count - first < chunk ? pairs.count - first : chunk;
    staged.fill(pairs, first, count);
    int left[chunk] = {};
    int left_count = 0;
    for (int k = 0; k < count; k += lanes) {
      Lanes3<Lanes<float>> a[3], b[3];
      load_corners(staged, k, a, b);
      const auto result = sifted(a, b, margin_low, margin_high);
      const int used = count - k < lanes ? count - k : lanes;
      for (int lane = 0; lane < used; ++lane) {
        verdict[first + k + lane] = to_verdict(result[lane]);
        left[left_count] = k + lane;
        left_count += result[lane] == 2;
      }
    }
    for (int k = 0; k < left_count; ++k) {
      open.copy(staged, left[k], open_count);
      place[open_count++] = first + left[k];
    }
    if (open_count <= chunk && first + chunk < pairs.count) continue;
    if (open_count > 0) open.pad(open_count);
    for (int k = 0; k < open_count; k += lanes) {
      const auto frame = load_frame(open, k);
      const auto result = verdict_of(frame, nearest_points<float>(frame), margin_low, margin_high);
      for (int lane = 0; lane < lanes && k + lane < open_count; ++lane)
        verdict[place[k + lane]] = to_verdict(result[lane]);
    }
    open_count = 0;
  }
}

void measure(const TrianglePairs& pairs, double margin, Verdict* verdict, double* squared_distance,
             bool* certain) {
  constexpr int lanes = lane_count<double>;
  using V = Lanes<double>;
  Staged<double> staged;
  for (int first = 0; first < pairs.count; first += chunk) {
    const int count = pairs.count - first < chunk ? pairs.count - first : chunk;
    staged.fill(pairs, first, count);
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
