// Loops that build a box pyramid. Compiled once per instruction set: see
// bsi/detail/instruction_set.h for the restrictions.
#include "bsi/kernels/box_build_kernels.h"

#include "bsi/kernels/wide_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

constexpr float lowest = -3.402823466e38F;  // -FLT_MAX, below all coordinates

// Computes, for every column c, the largest -value(r, c) and the largest value(r, c) over all rows
// r. With `join`, the previous results take part in the maximum.
template <bool join, class Value>
inline void bound_values(int count, int rows, float* __restrict minus_low, float* __restrict high,
                         const Value& value) {
  for (int first = 0; first < count; first += plane_padding) {
#pragma omp simd
    for (int c = first; c < first + plane_padding; ++c) {
      float low_bound = join ? minus_low[c] : lowest;
      float high_bound = join ? high[c] : lowest;
      for (int r = 0; r < rows; ++r) {
        const float v = value(r, c);
        low_bound = larger(low_bound, -v);
        high_bound = larger(high_bound, v);
      }
      minus_low[c] = low_bound;
      high[c] = high_bound;
    }
  }
}

template <bool join, int rows>
void bound_columns_of(const VertexRows& vertices, int quad_cols, BoundRow out) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto plane = [&](int number) { return out.plane + number * out.stride; };
    const float* row[rows];
    for (int r = 0; r < rows; ++r) row[r] = vertices.row[r][axis];
    bound_values<join>(quad_cols + 1, rows, plane(axis), plane(3 + axis),
                       [&](int r, int c) { return row[r][c]; });
  }
}

void bound_columns(const VertexRows& vertices, int quad_cols, bool join, BoundRow out) {
  if (vertices.count == 3) {
    join ? bound_columns_of<true, 3>(vertices, quad_cols, out)
         : bound_columns_of<false, 3>(vertices, quad_cols, out);
  } else {
    join ? bound_columns_of<true, 2>(vertices, quad_cols, out)
         : bound_columns_of<false, 2>(vertices, quad_cols, out);
  }
}

template <bool join, int rows>
void bound_steps_of(const VertexRows& vertices, int quad_cols, BoundRow out) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto plane = [&](int number) { return out.plane + number * out.stride; };
    const float* row[rows];
    for (int r = 0; r < rows; ++r) row[r] = vertices.row[r][axis];
    bound_values<join>(quad_cols, rows, plane(6 + axis), plane(12 + axis),
                       [&](int r, int c) { return row[r][c + 1] - row[r][c]; });
    bound_values<join>(quad_cols + 1, rows - 1, plane(9 + axis), plane(15 + axis),
                       [&](int r, int c) { return row[r + 1][c] - row[r][c]; });
  }
}

template <bool join>
void bound_steps_by_count(const VertexRows& vertices, int quad_cols, BoundRow out) {
  switch (vertices.count) {
    case 2:
      return bound_steps_of<join, 2>(vertices, quad_cols, out);
    case 3:
      return bound_steps_of<join, 3>(vertices, quad_cols, out);
    case 4:
      return bound_steps_of<join, 4>(vertices, quad_cols, out);
    default:
      return bound_steps_of<join, 5>(vertices, quad_cols, out);
  }
}

void bound_steps(const VertexRows& vertices, int quad_cols, bool join, BoundRow out) {
  join ? bound_steps_by_count<true>(vertices, quad_cols, out)
       : bound_steps_by_count<false>(vertices, quad_cols, out);
}

// Returns true if a plane holds bounds of steps along u. A block has one fewer such step than
// columns of vertices.
inline bool is_step_along_u(int plane) {
  return (plane >= 6 && plane < 9) || (plane >= 12 && plane < 15);
}

// Bounds consecutive blocks of two quads. Each block combines three columns of `in` if `third`,
// else two. Two columns suffice for steps along u.
inline void bound_pairs(const float* in, int blocks, bool third, float* bound) {
  const auto bound_at = [&](int u) {
    const float* from = in + 2 * u;
    const Wide first = load_wide(from), second = load_wide(from + width);
    Wide result = larger(even(first, second), odd(first, second));
    if (third) result = larger(result, even(load_wide(from + 2), load_wide(from + 2 + width)));
    store_wide(bound + u, result);
  };
  if (blocks >= width) {
    for (int u = 0; u + width <= blocks; u += width) bound_at(u);
    // The last vector overlaps the previous one, so that it stays within the row.
    if (blocks % width != 0) bound_at(blocks - width);
    return;
  }
  for (int u = 0; u < blocks; ++u) {
    bound[u] = larger(larger(in[2 * u], in[2 * u + 1]), in[2 * u + (third ? 2 : 1)]);
  }
}

// Bounds runs of blocks of two quads, separated by single blocks of one quad. 2^k quads form one
// run. 2^k - 1 quads (an image of 2^k vertices) form a single block and one run.
void bound_leaves(BoundRow columns, PlaneRange planes, const std::int32_t* boundary, int blocks,
                  BoundRow out) {
  for (int u = 0; u < blocks;) {
    const int begin = boundary[u];
    int pairs = 0;
    while (u + pairs < blocks && boundary[u + pairs + 1] == begin + 2 * (pairs + 1)) ++pairs;
    const bool single = u + pairs < blocks;
    for (int plane = planes.begin; plane < planes.end; ++plane) {
      const float* in = columns.plane + plane * columns.stride + begin;
      float* bound = out.plane + plane * out.stride + u;
      const bool third = !is_step_along_u(plane);
      bound_pairs(in, pairs, third, bound);
      if (single) bound[pairs] = larger(in[2 * pairs], in[2 * pairs + (third ? 1 : 0)]);
    }
    u += pairs + (single ? 1 : 0);
  }
}

void merge(BoundRow upper, BoundRow lower, PlaneRange planes, bool split_u, int blocks,
           BoundRow out) {
  for (int plane = planes.begin; plane < planes.end; ++plane) {
    const float* up = upper.plane + plane * upper.stride;
    const float* down = lower.plane + plane * lower.stride;
    float* __restrict bound = out.plane + plane * out.stride;
    if (split_u) {
      for (int u = 0; u < blocks; u += width) {
        const Wide first = larger(load_wide(up + 2 * u), load_wide(down + 2 * u));
        const Wide second = larger(load_wide(up + 2 * u + width), load_wide(down + 2 * u + width));
        store_wide(bound + u, larger(even(first, second), odd(first, second)));
      }
    } else {
#pragma omp simd
      for (int u = 0; u < blocks; ++u) bound[u] = larger(up[u], down[u]);
    }
  }
}

// Vectors of four and of two floats for unaligned access to arrays of floats.
typedef float Four __attribute__((vector_size(16), aligned(4), may_alias));
typedef float Two __attribute__((vector_size(8), aligned(4), may_alias));

inline Four children(const float* up, const float* down, int u) {
  const Two left = *reinterpret_cast<const Two*>(up + 2 * u);
  const Two right = *reinterpret_cast<const Two*>(down + 2 * u);
  return __builtin_shufflevector(left, right, 0, 1, 2, 3);
}

void store_groups(BoundRow upper, BoundRow lower, bool split_u, int blocks, BoxGroup* out) {
  for (int axis = 0; axis < 3; ++axis) {
    const float* up_low = upper.plane + axis * upper.stride;
    const float* up_high = upper.plane + (3 + axis) * upper.stride;
    if (split_u && lower.plane != nullptr) {
      const float* down_low = lower.plane + axis * lower.stride;
      const float* down_high = lower.plane + (3 + axis) * lower.stride;
      for (int u = 0; u < blocks; ++u) {
        *reinterpret_cast<Four*>(out[u].low[axis]) = -children(up_low, down_low, u);
        *reinterpret_cast<Four*>(out[u].high[axis]) = children(up_high, down_high, u);
      }
      continue;
    }
    for (int u = 0; u < blocks; ++u) {
      for (int child = 0; child < 4; ++child) {
        const int column = split_u ? 2 * u + child % 2 : u;
        const BoundRow& row = child < 2 ? upper : lower;
        const bool there = row.plane != nullptr && (split_u || child % 2 == 0);
        out[u].low[axis][child] = there ? -row.plane[axis * row.stride + column] : -lowest;
        out[u].high[axis][child] = there ? row.plane[(3 + axis) * row.stride + column] : lowest;
      }
    }
  }
}

void store_tangents(BoundRow row, int blocks, TangentBounds* out) {
  for (int u = 0; u < blocks; ++u) {
    for (int plane = 0; plane < 12; ++plane) {
      out[u].bound[plane] = row.plane[(6 + plane) * row.stride + u];
    }
  }
}

}  // namespace

extern const BoxBuildKernels box_build_kernels;
const BoxBuildKernels box_build_kernels = {bound_columns, bound_steps,  bound_leaves,
                                           merge,         store_groups, store_tangents};

}  // namespace weft::bsi::WEFT_KERNELS
