// The proof that two neighbouring blocks cannot touch. For kernel files alone, as box_lanes.h.
#pragma once

#include "bsi/box_descent_kernels.h"
#include "bsi/box_nodes.h"

namespace weft::bsi::WEFT_KERNELS {

WEFT_INLINE double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// One side of the hexagon, from p to q, which stray by so much along each axis: true only if all
// that it can be lies beyond the margin, seen along about the perpendicular from the origin. `size`
// is no smaller than any component of what was computed on the way to p and q.
WEFT_INLINE bool is_beyond(const double p[3], const double stray_p[3], const double q[3],
                           const double stray_q[3], const double size[3], double margin) {
  const double side[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
  const double along = dot(side, side), back = dot(p, side);
  double normal[3], magnitude[3];
  for (int i = 0; i < 3; ++i) {
    normal[i] = p[i] * along - side[i] * back;
    magnitude[i] = __builtin_fabs(normal[i]);
  }
  const double reach_p = dot(normal, p) - dot(magnitude, stray_p);
  const double reach_q = dot(normal, q) - dot(magnitude, stray_q);
  const double reach = reach_p < reach_q ? reach_p : reach_q;
  // Rounding takes less than 2^-46 of the last product.
  return reach > __builtin_sqrt(dot(normal, normal)) * margin + 0x1p-46 * dot(magnitude, size);
}

// True only if no two points of a rectangle of quads whose steps have these bounds come within the
// margin of each other, unless they lie on triangles with a common vertex (docs/theory.md, "The
// tangent certificate"): the hexagon of the steps along u, along v and along the diagonals keeps
// clear of the margin. In float64: a fourth power of a coordinate is out of the range of float32.
WEFT_INLINE bool certified(const float bound[16], double margin) {
  double mean[2][3], stray[2][3];
  for (int i = 0; i < 6; ++i) {
    const double low = -static_cast<double>(bound[i]), high = static_cast<double>(bound[6 + i]);
    mean[i / 3][i % 3] = 0.5 * (high + low);
    stray[i / 3][i % 3] = 0.5 * (high - low);
  }
  double diagonal[3], stray_diagonal[3], back[3], size[3];
  for (int i = 0; i < 3; ++i) {
    diagonal[i] = mean[1][i] - mean[0][i];
    stray_diagonal[i] = stray[0][i] + stray[1][i];
    back[i] = -mean[0][i];
    size[i] = __builtin_fabs(mean[0][i]) + __builtin_fabs(mean[1][i]) + stray_diagonal[i];
  }
  return is_beyond(mean[0], stray[0], mean[1], stray[1], size, margin) &&
         is_beyond(mean[1], stray[1], diagonal, stray_diagonal, size, margin) &&
         is_beyond(diagonal, stray_diagonal, back, stray[0], size, margin);
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
