#include "bsi/block_row.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "bsi/sphere_bounds.h"

namespace weft::bsi {

void BlockRow::reserve(std::size_t blocks) {
  if (blocks <= radius.size()) return;
  for (Components* set : {&low, &high, &centre}) {
    for (auto& component : *set) component.resize(blocks);
  }
  radius.resize(blocks);
}

void BlockRow::clear(int blocks) {
  constexpr float empty_corner = std::numeric_limits<float>::max();
  for (int axis = 0; axis < 3; ++axis) {
    std::fill_n(low[axis].begin(), blocks, empty_corner);
    std::fill_n(high[axis].begin(), blocks, -empty_corner);
    std::fill_n(centre[axis].begin(), blocks, 0.0F);
  }
  std::fill_n(radius.begin(), blocks, -1.0F);
}

namespace {

inline Interval range(const float* values, int i, int j) {
  return {smaller(values[i], values[j]), larger(values[i], values[j])};
}

// Points in one array a component.
template <typename Float>
struct Points {
  Float* x;
  Float* y;
  Float* z;
};

Points<const float> points(const Components& components) {
  return {components[0].data(), components[1].data(), components[2].data()};
}

Points<float> points(Components& components) {
  return {components[0].data(), components[1].data(), components[2].data()};
}

// A row of blocks.
template <typename Float>
struct BlockRowView {
  Points<Float> low, high, centre;
  Float* radius;
};

BlockRowView<const float> view(const BlockRow& row) {
  return {points(row.low), points(row.high), points(row.centre), row.radius.data()};
}

BlockRowView<float> view(BlockRow& row) {
  return {points(row.low), points(row.high), points(row.centre), row.radius.data()};
}

inline void store(const Points<float>& target, int i, float x, float y, float z) {
  target.x[i] = x;
  target.y[i] = y;
  target.z[i] = z;
}

inline void store(const BlockRowView<float>& target, int i, Interval x, Interval y, Interval z,
                  float radius) {
  store(target.low, i, x.low, y.low, z.low);
  store(target.high, i, x.high, y.high, z.high);
  store(target.centre, i, x.middle(), y.middle(), z.middle());
  target.radius[i] = radius;
}

inline float squared_distance(const Points<const float>& points, int i, Interval x, Interval y,
                              Interval z) {
  return square(points.x[i] - x.middle(), points.y[i] - y.middle(), points.z[i] - z.middle());
}

// The rows of vertices above and below a row of quads, at one or both ends of their paths.
template <int ends>
struct QuadCorners {
  Points<const float> up, down, up_end, down_end;
};

// The bodies of the two loops that a rebuild spends its time in. They are functions without loops
// of their own, or g++ 12 would not vectorise the loops that call them.
template <int ends>
inline void bound_quad(const QuadCorners<ends>& corners, int i, const BlockRowView<float>& target) {
  const auto& [up, down, up_end, down_end] = corners;
  Interval x = join(range(up.x, i, i + 1), range(down.x, i, i + 1));
  Interval y = join(range(up.y, i, i + 1), range(down.y, i, i + 1));
  Interval z = join(range(up.z, i, i + 1), range(down.z, i, i + 1));
  if constexpr (ends == 2) {
    x = join(x, join(range(up_end.x, i, i + 1), range(down_end.x, i, i + 1)));
    y = join(y, join(range(up_end.y, i, i + 1), range(down_end.y, i, i + 1)));
    z = join(z, join(range(up_end.z, i, i + 1), range(down_end.z, i, i + 1)));
  }
  const auto reach = [&](const Points<const float>& row) {
    return larger(squared_distance(row, i, x, y, z), squared_distance(row, i + 1, x, y, z));
  };
  float squared = larger(reach(up), reach(down));
  if constexpr (ends == 2) squared = larger(squared, larger(reach(up_end), reach(down_end)));
  store(target, i, x, y, z, cover(std::sqrt(squared), magnitude(x, y, z)));
}

// Children that are empty count for nothing.
template <bool split_u>
inline void merge_blocks(const BlockRowView<const float>& up, const BlockRowView<const float>& down,
                         int i, const BlockRowView<float>& target) {
  const int left = split_u ? 2 * i : i;
  const int right = split_u ? 2 * i + 1 : i;
  const auto box = [&](const float* up_low, const float* down_low, const float* up_high,
                       const float* down_high) {
    return Interval{smaller(range(up_low, left, right).low, range(down_low, left, right).low),
                    larger(range(up_high, left, right).high, range(down_high, left, right).high)};
  };
  const Interval x = box(up.low.x, down.low.x, up.high.x, down.high.x);
  const Interval y = box(up.low.y, down.low.y, up.high.y, down.high.y);
  const Interval z = box(up.low.z, down.low.z, up.high.z, down.high.z);
  const auto reach = [&](const BlockRowView<const float>& row, int child) {
    const float distance = std::sqrt(squared_distance(row.centre, child, x, y, z));
    return row.radius[child] < 0 ? -1.0F : distance + row.radius[child];
  };
  const float carried = larger(larger(reach(up, left), reach(up, right)),
                               larger(reach(down, left), reach(down, right)));
  const float bound = smaller(cover(half_diagonal(x, y, z), magnitude(x, y, z)), carry(carried));
  store(target, i, x, y, z, carried < 0 ? -1.0F : bound);
}

template <int ends>
void bound_quads_at(const VertexRow& upper, const VertexRow& lower, int quads, BlockRow& out) {
  const QuadCorners<ends> corners{points(upper[0]), points(lower[0]), points(upper[ends - 1]),
                                  points(lower[ends - 1])};
  const BlockRowView<float> target = view(out);
#pragma omp simd
  for (int i = 0; i < quads; ++i) bound_quad(corners, i, target);
}

template <bool split_u>
void merge_rows_by(const BlockRow& upper, const BlockRow& lower, int blocks, BlockRow& out) {
  const BlockRowView<const float> up = view(upper);
  const BlockRowView<const float> down = view(lower);
  const BlockRowView<float> target = view(out);
#pragma omp simd
  for (int i = 0; i < blocks; ++i) merge_blocks<split_u>(up, down, i, target);
}

}  // namespace

void bound_quads(const VertexRow& upper, const VertexRow& lower, int ends, int quads,
                 BlockRow& out) {
  assert(ends == 1 || ends == 2);
  if (ends == 1) {
    bound_quads_at<1>(upper, lower, quads, out);
  } else {
    bound_quads_at<2>(upper, lower, quads, out);
  }
}

void spread_quads(const BlockRow& row, int quads, int blocks, BlockRow& out) {
  out.clear(blocks);
  const int log = ceil_log2(quads);
  for (int u = 0; u < blocks; ++u) {
    const int quad = block_boundary(u, quads, log);
    if (quad == block_boundary(u + 1, quads, log)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      out.low[axis][u] = row.low[axis][quad];
      out.high[axis][u] = row.high[axis][quad];
      out.centre[axis][u] = row.centre[axis][quad];
    }
    out.radius[u] = row.radius[quad];
  }
}

void merge_rows(const BlockRow& upper, const BlockRow& lower, bool split_u, int blocks,
                BlockRow& out) {
  if (split_u) {
    merge_rows_by<true>(upper, lower, blocks, out);
  } else {
    merge_rows_by<false>(upper, lower, blocks, out);
  }
}

}  // namespace weft::bsi
