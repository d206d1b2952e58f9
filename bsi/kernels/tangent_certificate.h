// The tangent certificate: a proof that a block cannot touch itself, or that two neighbouring
// blocks cannot touch, apart from features with a common vertex. For kernel files only, like
// box_lanes.h.
#pragma once

#include "bsi/kernels/box_descent_kernels.h"
#include "bsi/kernels/box_nodes.h"

namespace weft::bsi::WEFT_KERNELS {

// One number for each of three sides of a hexagon; the other three sides are their opposites. The
// fourth lane is unused.
typedef double Sides __attribute__((vector_size(32)));
struct Sides3 {
  Sides x, y, z;
};

WEFT_INLINE Sides dot(const Sides3& a, const Sides3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
WEFT_INLINE Sides3 operator-(const Sides3& a, const Sides3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
WEFT_INLINE Sides3 scaled(const Sides3& a, Sides factor) {
  return {a.x * factor, a.y * factor, a.z * factor};
}
WEFT_INLINE Sides magnitude(Sides a) {
  typedef std::int64_t Bits __attribute__((vector_size(32)));
  return reinterpret_cast<Sides>(reinterpret_cast<Bits>(a) & 0x7fffffffffffffff);
}
WEFT_INLINE Sides square_root(Sides a) {
#if defined(__AVX__)
  return _mm256_sqrt_pd(a);
#else
  return Sides{__builtin_sqrt(a[0]), __builtin_sqrt(a[1]), __builtin_sqrt(a[2]),
               __builtin_sqrt(a[3])};
#endif
}

// Returns true only if every side of the hexagon is proved to be farther than the margin from the
// origin. Each side runs from p to q, and the proof uses a direction nearly perpendicular to it.
// The ends of a side may deviate from p and q by `stray_*` along each axis. `size` bounds, by axis,
// the values from which p and q are computed.
WEFT_INLINE bool are_beyond(const Sides3& p, const Sides3& stray_p, const Sides3& q,
                            const Sides3& stray_q, const Sides3& size, double margin) {
  const Sides3 side = q - p;
  const Sides3 normal = scaled(p, dot(side, side)) - scaled(side, dot(p, side));
  const Sides3 magnitudes{magnitude(normal.x), magnitude(normal.y), magnitude(normal.z)};
  const Sides reach_p = dot(normal, p) - dot(magnitudes, stray_p);
  const Sides reach_q = dot(normal, q) - dot(magnitudes, stray_q);
  const Sides reach = reach_p < reach_q ? reach_p : reach_q;
  // The last term exceeds all rounding in the comparison below.
  const Sides least = square_root(dot(normal, normal)) * margin + 0x1p-46 * dot(magnitudes, size);
  const auto beyond = reach > least;
  return (beyond[0] & beyond[1] & beyond[2]) != 0;
}

// A vector of the values of TangentBounds::bound.
typedef float StepBounds __attribute__((vector_size(64), may_alias));

// Returns true only if any two features (vertices, edges or triangles) of a rectangle of quads
// without a common vertex are proved to stay farther apart than the margin. `bound` holds the
// bounds of the rectangle's steps. The proof (docs/theory.md, "The tangent certificate") tests the
// hexagon of the steps along u, v and the diagonal. Float64 is needed, because powers of
// coordinates can exceed the range of float32.
WEFT_INLINE bool certified(StepBounds bound, double margin) {
  typedef double Steps __attribute__((vector_size(64)));
  const Steps minus_low =
      __builtin_convertvector(__builtin_shufflevector(bound, bound, 0, 1, 2, 3, 4, 5, 6, 7), Steps);
  const Steps high = __builtin_convertvector(
      __builtin_shufflevector(bound, bound, 6, 7, 8, 9, 10, 11, 12, 13), Steps);
  // Middles and half widths of the bounds of the steps: along u (x, y, z), then along v.
  alignas(64) double mean[8], stray[8];
  *reinterpret_cast<Steps*>(mean) = 0.5 * (high - minus_low);
  *reinterpret_cast<Steps*>(stray) = 0.5 * (high + minus_low);
  // The three sides run from u to v, from v to the diagonal v - u, and from the diagonal to -u.
  constexpr Sides u_in_p = {1, 0, -1, 1}, v_in_p = {0, 1, 1, 0};
  constexpr Sides u_in_q = {0, -1, -1, 0}, v_in_q = {1, 1, 0, 1};
  Sides p[3], q[3], stray_p[3], stray_q[3], size[3];
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
    const Sides u = Sides{} + mean[axis], v = Sides{} + mean[3 + axis];
    const Sides stray_u = Sides{} + stray[axis], stray_v = Sides{} + stray[3 + axis];
    p[axis] = u * u_in_p + v * v_in_p;
    q[axis] = u * u_in_q + v * v_in_q;
    stray_p[axis] = stray_u * magnitude(u_in_p) + stray_v * v_in_p;
    stray_q[axis] = stray_u * magnitude(u_in_q) + stray_v * v_in_q;
    size[axis] = magnitude(u) + magnitude(v) + (stray_u + stray_v);
  }
  return are_beyond({p[0], p[1], p[2]}, {stray_p[0], stray_p[1], stray_p[2]}, {q[0], q[1], q[2]},
                    {stray_q[0], stray_q[1], stray_q[2]}, {size[0], size[1], size[2]}, margin);
}

// Returns true if the positions a and b of two blocks differ by at most one along an axis of
// `blocks` blocks, also across the seam of a wrapped axis. `step` is then the offset from a to b:
// -1, 0 or 1.
WEFT_INLINE bool are_neighbours(int a, int b, int blocks, bool wraps, int& step) {
  step = b - a;
  if (wraps && step == blocks - 1) step = -1;
  if (wraps && step == 1 - blocks) step = 1;
  return step >= -1 && step <= 1;
}

// Returns true if the certificate holds for a block paired with itself, or for the rectangle of two
// or four blocks that contains two neighbours.
WEFT_INLINE bool cannot_touch(const DescentQuery& query, const NodePair& pair,
                              DescentCounters& counters) {
  const BoxLevel& level = level_of(*query.a, pair.a);
  if (query.certificate_margin < 0 || level.tangents == nullptr || pair.a.level != pair.b.level) {
    return false;
  }
  const BoxPatch& patch = query.a->patches[level.patch];
  int step_u = 0, step_v = 0;
  if (!are_neighbours(pair.a.u, pair.b.u, 1 << level.log_u, patch.wrap_u != 0, step_u) ||
      !are_neighbours(pair.a.v, pair.b.v, 1 << level.log_v, patch.wrap_v != 0, step_v)) {
    return false;
  }
  ++counters.certificate_tests;
  const auto bounds_at = [&](std::uint16_t u, std::uint16_t v) {
    const BoxNode block{pair.a.level, u, v};
    return *reinterpret_cast<const StepBounds*>(level.tangents[block_of(level, block)].bound);
  };
  StepBounds bound = bounds_at(pair.a.u, pair.a.v);
  const auto join = [&](std::uint16_t u, std::uint16_t v) {
    const StepBounds other = bounds_at(u, v);
    bound = bound > other ? bound : other;
  };
  if (step_u != 0) join(pair.b.u, pair.a.v);
  if (step_v != 0) join(pair.a.u, pair.b.v);
  if (step_u != 0 && step_v != 0) join(pair.b.u, pair.b.v);
  const bool proved = certified(bound, query.certificate_margin);
  counters.certified += proved ? 1 : 0;
  return proved;
}

}  // namespace weft::bsi::WEFT_KERNELS
