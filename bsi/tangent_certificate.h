// The proof that two neighbouring blocks cannot touch. For kernel files alone, as box_lanes.h.
#pragma once

#include "bsi/box_descent_kernels.h"
#include "bsi/box_nodes.h"

namespace weft::bsi::WEFT_KERNELS {

// The three sides of half a hexagon at once, and one lane more.
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
WEFT_INLINE Sides magnitude(Sides a) { return a < 0 ? -a : a; }
WEFT_INLINE Sides square_root(Sides a) {
  return Sides{__builtin_sqrt(a[0]), __builtin_sqrt(a[1]), __builtin_sqrt(a[2]),
               __builtin_sqrt(a[3])};
}

// The sides of the hexagon, from p to q, which stray by so much along each axis: true only if all
// that they can be lies beyond the margin, seen along about the perpendicular from the origin.
// `size` is no smaller than any component of what was computed on the way to p and q.
WEFT_INLINE bool are_beyond(const Sides3& p, const Sides3& stray_p, const Sides3& q,
                            const Sides3& stray_q, const Sides3& size, double margin) {
  const Sides3 side = q - p;
  const Sides3 normal = scaled(p, dot(side, side)) - scaled(side, dot(p, side));
  const Sides3 magnitudes{magnitude(normal.x), magnitude(normal.y), magnitude(normal.z)};
  const Sides reach_p = dot(normal, p) - dot(magnitudes, stray_p);
  const Sides reach_q = dot(normal, q) - dot(magnitudes, stray_q);
  const Sides reach = reach_p < reach_q ? reach_p : reach_q;
  // Rounding takes less than 2^-46 of the last product.
  const Sides least = square_root(dot(normal, normal)) * margin + 0x1p-46 * dot(magnitudes, size);
  return reach[0] > least[0] && reach[1] > least[1] && reach[2] > least[2];
}

// One component of the steps within a block: their mean along u and along v, and how far they stray
// from it, on either side.
struct StepBounds {
  double mean_u, mean_v, stray_u, stray_v;
};

WEFT_INLINE StepBounds step_bounds(const float bound[16], int axis) {
  const double low_u = -static_cast<double>(bound[axis]), high_u = bound[6 + axis];
  const double low_v = -static_cast<double>(bound[3 + axis]), high_v = bound[9 + axis];
  return {0.5 * (high_u + low_u), 0.5 * (high_v + low_v), 0.5 * (high_u - low_u),
          0.5 * (high_v - low_v)};
}

// True only if no two points of a rectangle of quads whose steps have these bounds come within the
// margin of each other, unless they lie on triangles with a common vertex (docs/theory.md, "The
// tangent certificate"): the hexagon of the steps along u, along v and along the diagonals keeps
// clear of the margin. In float64: a fourth power of a coordinate is out of the range of float32.
WEFT_INLINE bool certified(const float bound[16], double margin) {
  Sides p[3], q[3], stray_p[3], stray_q[3], size[3];
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
    const StepBounds step = step_bounds(bound, axis);
    const double diagonal = step.mean_v - step.mean_u;
    const double stray = step.stray_u + step.stray_v;
    // From u to v, from v to the diagonal, from the diagonal to -u.
    p[axis] = Sides{step.mean_u, step.mean_v, diagonal, step.mean_u};
    q[axis] = Sides{step.mean_v, diagonal, -step.mean_u, step.mean_v};
    stray_p[axis] = Sides{step.stray_u, step.stray_v, stray, step.stray_u};
    stray_q[axis] = Sides{step.stray_v, stray, step.stray_u, step.stray_v};
    size[axis] = Sides{} + (__builtin_fabs(step.mean_u) + __builtin_fabs(step.mean_v) + stray);
  }
  return are_beyond({p[0], p[1], p[2]}, {stray_p[0], stray_p[1], stray_p[2]}, {q[0], q[1], q[2]},
                    {stray_q[0], stray_q[1], stray_q[2]}, {size[0], size[1], size[2]}, margin);
}

// Where two blocks of one level are neighbours (or one and the same): true, and their distance in
// blocks along an axis, -1 .. 1.
WEFT_INLINE bool are_neighbours(int a, int b, int blocks, bool wraps, int& step) {
  step = b - a;
  if (wraps && step == blocks - 1) step = -1;
  if (wraps && step == 1 - blocks) step = 1;
  return step >= -1 && step <= 1;
}

// A block with itself, or two neighbours in the window of up to 2 x 2 blocks that holds both.
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
  alignas(64) float bound[16];
  const TangentBounds& own = level.tangents[block_of(level, pair.a)];
  for (int i = 0; i < 16; ++i) bound[i] = own.bound[i];
  const auto join = [&](std::uint16_t u, std::uint16_t v) {
    const TangentBounds& other = level.tangents[block_of(level, {pair.a.level, u, v})];
    for (int i = 0; i < 16; ++i) bound[i] = larger(bound[i], other.bound[i]);
  };
  if (step_u != 0) join(pair.b.u, pair.a.v);
  if (step_v != 0) join(pair.a.u, pair.b.v);
  if (step_u != 0 && step_v != 0) join(pair.b.u, pair.b.v);
  const bool proved = certified(bound, query.certificate_margin);
  counters.certified += proved ? 1 : 0;
  return proved;
}

}  // namespace weft::bsi::WEFT_KERNELS
