#include "bsi/pyramid.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <type_traits>

namespace weft::bsi {

namespace {

// Rounding bounds, with u = 2^-24 the unit roundoff of float32. A length computed as sqrt(dx^2 +
// dy^2 + dz^2) from float32 differences falls short by at most 3.5 u of itself; adding a radius and
// multiplying make it 5.5 u (standard model, Higham 2002, section 2.2), less than round_up adds.
constexpr float round_up = 1 + 0x1p-21F;
// Rounding a vertex to float32 moves it by at most sqrt(3) u of its largest coordinate.
constexpr float vertex_rounding = 0x1p-23F;
// Added to every radius: far below anything physical, and above all that underflow can lose (the
// square of a length under 1e-22 m, or one flushed to zero under 1e-19 m).
constexpr float radius_floor = 1e-18F;
// Corner of an empty box: low = +empty_corner, high = -empty_corner, neutral to min and max.
constexpr float empty_corner = std::numeric_limits<float>::max();

// By value: g++ 12 does not vectorise the std ones, which return references.
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }

inline float square(float x, float y, float z) { return x * x + y * y + z * z; }

// One axis of a box of float32 vertices.
struct Interval {
  float low;
  float high;
  float middle() const { return 0.5F * (low + high); }
  // Of the middle, which is rounded.
  float half() const { return larger(high - middle(), middle() - low); }
  float magnitude() const { return larger(std::fabs(low), std::fabs(high)); }
};

inline Interval join(Interval a, Interval b) {
  return {smaller(a.low, b.low), larger(a.high, b.high)};
}

inline Interval range(const float* values, int i, int j) {
  return {smaller(values[i], values[j]), larger(values[i], values[j])};
}

inline float half_diagonal(Interval x, Interval y, Interval z) {
  return std::sqrt(square(x.half(), y.half(), z.half()));
}

// The largest magnitude of a coordinate.
inline float magnitude(Interval x, Interval y, Interval z) {
  return larger(x.magnitude(), larger(y.magnitude(), z.magnitude()));
}

// Radius that covers float64 vertices, given how far their float32 roundings reach.
inline float cover(float reach, float largest_coordinate) {
  return reach * round_up + (largest_coordinate * vertex_rounding + radius_floor);
}

// Points in one array a component.
template <typename Float>
struct Points {
  Float* x;
  Float* y;
  Float* z;
};

Points<const float> points(const std::array<std::vector<float>, 3>& components) {
  return {components[0].data(), components[1].data(), components[2].data()};
}

Points<float> points(std::array<std::vector<float>, 3>& components) {
  return {components[0].data(), components[1].data(), components[2].data()};
}

// A row of blocks.
template <typename Float>
struct BlockRowView {
  Points<Float> low, high, centre;
  Float* radius;
};

template <typename BlockRow>
auto view(BlockRow& row) {
  using Float = std::remove_pointer_t<decltype(row.radius.data())>;
  return BlockRowView<Float>{points(row.low), points(row.high), points(row.centre),
                             row.radius.data()};
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
  const float bound =
      smaller(cover(half_diagonal(x, y, z), magnitude(x, y, z)), carried * round_up + radius_floor);
  store(target, i, x, y, z, carried < 0 ? -1.0F : bound);
}

int ceil_log2(int count) { return std::bit_width(static_cast<unsigned>(count) - 1); }

// Boundary k of 2^log nested blocks of `count` items: floor(k * count / 2^log).
int boundary(int k, int count, int log) {
  return static_cast<int>((static_cast<std::int64_t>(k) * count) >> log);
}

// So few quads that visiting their vertices costs less than pruning.
bool is_small(const QuadRange& range) {
  constexpr int few_quads = 16;
  return (range.row_end - range.row_begin) * (range.col_end - range.col_begin) <= few_quads;
}

Vec3 centre_of(const Sphere& sphere) { return {sphere.x, sphere.y, sphere.z}; }

float centre_distance(const Sphere& a, const Sphere& b) {
  return std::sqrt(square(a.x - b.x, a.y - b.y, a.z - b.z));
}

}  // namespace

double bounding_sphere_gap(const Sphere& first, const Sphere& second) {
  if (first.radius < 0 || second.radius < 0) return std::numeric_limits<double>::infinity();
  // The distance is good to 4 units of 2^-53, the sum of radii to one.
  const double distance = (centre_of(first) - centre_of(second)).norm() * (1 - 0x1p-49);
  const double radii = static_cast<double>(first.radius) + static_cast<double>(second.radius);
  return std::max(0.0, distance - radii);
}

Pyramid::Pyramid(const Atlas& atlas, RadiusPolicy policy) : atlas_(atlas), policy_(policy) {
  for (const Patch& patch : atlas.patches()) add_levels(patch);
  const int patches = patch_count();
  patch_boxes_.resize(patches);
  group_levels_ = ceil_log2(patches);
  first_group_ = spheres_.size();
  spheres_.resize(first_group_ + (std::size_t{1} << group_levels_) - 1);
}

void Pyramid::add_levels(const Patch& patch) {
  const int depth_u = ceil_log2(patch.quad_cols());
  const int depth_v = ceil_log2(patch.quad_rows());
  const int count = std::max(depth_u, depth_v) + 1;
  if (static_cast<std::size_t>(count) > block_rows_.size()) block_rows_.resize(count);
  for (int level = 0; level < count; ++level) {
    const Level place{spheres_.size(), std::min(level, depth_u), std::min(level, depth_v)};
    spheres_.resize(place.first + (std::size_t{1} << (place.log_u + place.log_v)));
    level_table_.push_back(place);
    for (BlockRow& row : block_rows_[level]) row.resize(std::size_t{1} << place.log_u);
  }
  first_level_.push_back(static_cast<int>(level_table_.size()));
  quad_row_.resize(patch.quad_cols());
  const std::size_t vertices = static_cast<std::size_t>(patch.quad_cols()) + 1;
  for (VertexRow& row : vertex_rows_) {
    for (auto& end : row) {
      for (auto& component : end) component.resize(std::max(component.size(), vertices));
    }
  }
}

void Pyramid::BlockRow::resize(std::size_t blocks) {
  if (blocks <= radius.size()) return;
  for (auto* box : {&low, &high, &centre}) {
    for (auto& component : *box) component.resize(blocks);
  }
  radius.resize(blocks);
}

void Pyramid::BlockRow::clear(int blocks) {
  for (int axis = 0; axis < 3; ++axis) {
    std::fill_n(low[axis].begin(), blocks, empty_corner);
    std::fill_n(high[axis].begin(), blocks, -empty_corner);
    std::fill_n(centre[axis].begin(), blocks, 0.0F);
  }
  std::fill_n(radius.begin(), blocks, -1.0F);
}

QuadRange Pyramid::quads(int patch, int level, int u, int v) const {
  const Level& place = level_of(patch, level);
  const int rows = atlas_.patches()[patch].quad_rows();
  const int cols = atlas_.patches()[patch].quad_cols();
  return {boundary(v, rows, place.log_v), boundary(v + 1, rows, place.log_v),
          boundary(u, cols, place.log_u), boundary(u + 1, cols, place.log_u)};
}

std::span<const Sphere> Pyramid::level_spheres(int patch, int level) const {
  const Level& place = level_of(patch, level);
  return std::span(spheres_).subspan(place.first, std::size_t{1} << (place.log_u + place.log_v));
}

std::span<const Sphere> Pyramid::group_spheres(int level) const {
  const std::size_t count = std::size_t{1} << level;
  return std::span(spheres_).subspan(first_group_ + count - 1, count);
}

std::array<int, 2> Pyramid::patches_of_group(int level, int index) const {
  return {boundary(index, patch_count(), level), boundary(index + 1, patch_count(), level)};
}

int Pyramid::quad_of_leaf(const Block& leaf) const {
  assert(is_leaf(leaf));
  const QuadRange range = quads(leaf);
  assert(!range.empty());
  return atlas_.first_quad(leaf.patch) +
         range.row_begin * atlas_.patches()[leaf.patch].quad_cols() + range.col_begin;
}

int Pyramid::children(const Block& block, std::array<Block, 4>& child) const {
  assert(!is_leaf(block));
  const int next = block.level + 1;
  if (block.patch == Block::group && next < group_levels_) {
    // Every one of these groups has a patch: there are more patches than groups.
    child[0] = {Block::group, next, 2 * block.u, 0};
    child[1] = {Block::group, next, 2 * block.u + 1, 0};
    return 2;
  }
  if (block.patch == Block::group) {
    const auto [begin, end] = patches_of_group(block.level, block.u);
    for (int patch = begin; patch < end; ++patch) child[patch - begin] = {patch, 0, 0, 0};
    return end - begin;
  }
  const Level& here = level_of(block.patch, block.level);
  const Level& below = level_of(block.patch, next);
  const int split_u = below.log_u - here.log_u;
  const int split_v = below.log_v - here.log_v;
  int count = 0;
  for (int v = block.v << split_v; v < (block.v + 1) << split_v; ++v) {
    for (int u = block.u << split_u; u < (block.u + 1) << split_u; ++u) {
      const Block candidate{block.patch, next, u, v};
      if (sphere(candidate).radius >= 0) child[count++] = candidate;
    }
  }
  return count;
}

std::optional<TexelAddress> Pyramid::rebuild(std::span<const Vec3> positions) {
  ends_ = {positions, {}};
  end_count_ = 1;
  return rebuild_all();
}

std::optional<TexelAddress> Pyramid::rebuild_swept(std::span<const Vec3> start,
                                                   std::span<const Vec3> end) {
  ends_ = {start, end};
  end_count_ = 2;
  return rebuild_all();
}

std::optional<TexelAddress> Pyramid::rebuild_all() {
  for (int end = 0; end < end_count_; ++end) {
    assert(static_cast<int>(ends_[end].size()) == atlas_.particle_count());
  }
  built_ = false;
  for (int patch = 0; patch < patch_count(); ++patch) {
    if (const auto place = rebuild_patch(patch)) return place;
    if (policy_ == RadiusPolicy::fast) tighten_top_levels(patch);
  }
  rebuild_groups();
  if (policy_ == RadiusPolicy::exact) refine_to_exact();
  built_ = true;
  return std::nullopt;
}

// Row after row of quads; a parent's row is made as soon as those of its children are there, while
// they are still in the cache.
std::optional<TexelAddress> Pyramid::rebuild_patch(int patch) {
  const Patch& size = atlas_.patches()[patch];
  const int leaf_level = levels(patch) - 1;
  const Level& leaves = level_of(patch, leaf_level);
  const auto load = [&](int row) {
    VertexRow& vertices = vertex_rows_[row & 1];
    const int texel_row = row < size.rows ? row : 0;
    return end_count_ == 1 ? load_row<1>(patch, texel_row, vertices)
                           : load_row<2>(patch, texel_row, vertices);
  };
  if (!load(0)) return first_unbounded(patch, 0);
  for (int v = 0; v < 1 << leaves.log_v; ++v) {
    const int quad_row = boundary(v, size.quad_rows(), leaves.log_v);
    BlockRow& out = block_rows_[leaf_level][v & 1];
    if (quad_row == boundary(v + 1, size.quad_rows(), leaves.log_v)) {
      out.clear(1 << leaves.log_u);
    } else {
      if (!load(quad_row + 1)) return first_unbounded(patch, quad_row + 1);
      bound_row_of_quads(size, quad_row, 1 << leaves.log_u, out);
    }
    finish_row(patch, leaf_level, v);
  }
  return std::nullopt;
}

// Rounds a row of vertices to float32. False if one of them cannot be bounded.
template <int ends>
bool Pyramid::load_row(int patch, int row, VertexRow& vertices) const {
  const Patch& size = atlas_.patches()[patch];
  const int first = atlas_.first_texel(patch) + row * size.cols;
  int unbounded = 0;
  for (int end = 0; end < ends; ++end) {
    float* x = vertices[end][0].data();
    float* y = vertices[end][1].data();
    float* z = vertices[end][2].data();
    const auto store = [&](int col, const Vec3& position) {
      x[col] = static_cast<float>(position.x());
      y[col] = static_cast<float>(position.y());
      z[col] = static_cast<float>(position.z());
      // False for NaN too, which minima and maxima would swallow.
      const bool bounded = (std::fabs(x[col]) < coordinate_limit) &
                           (std::fabs(y[col]) < coordinate_limit) &
                           (std::fabs(z[col]) < coordinate_limit);
      return bounded ? 0 : 1;
    };
    const Vec3* positions = ends_[end].data();
    if (atlas_.is_identity()) {
#pragma omp simd reduction(| : unbounded)
      for (int col = 0; col < size.cols; ++col) unbounded |= store(col, positions[first + col]);
    } else {
      for (int col = 0; col < size.cols; ++col) {
        unbounded |= store(col, positions[atlas_.particle_of_texel(first + col)]);
      }
    }
    if (size.wrap_u) {
      for (auto& component : vertices[end]) component[size.cols] = component[0];
    }
  }
  return unbounded == 0;
}

// The first texel of a row, of those that load_row refuses.
TexelAddress Pyramid::first_unbounded(int patch, int row) const {
  for (int col = 0;; ++col) {
    assert(col < atlas_.patches()[patch].cols);
    const int particle = atlas_.particle(patch, row, col);
    for (int end = 0; end < end_count_; ++end) {
      const Eigen::Vector3f rounded = ends_[end][particle].cast<float>();
      // Not a maximum, which swallows NaN.
      if (!(rounded.array().abs() < coordinate_limit).all()) return {patch, row, col};
    }
  }
}

void Pyramid::bound_row_of_quads(const Patch& size, int quad_row, int blocks, BlockRow& out) {
  const VertexRow& upper = vertex_rows_[quad_row & 1];
  const VertexRow& lower = vertex_rows_[(quad_row + 1) & 1];
  const int quads = size.quad_cols();
  // Blocks of a power of two are the quads; otherwise quads are spread among empty blocks.
  BlockRow& bounded = blocks == quads ? out : quad_row_;
  if (end_count_ == 1) {
    bound_quads<1>(upper, lower, quads, bounded);
  } else {
    bound_quads<2>(upper, lower, quads, bounded);
  }
  if (blocks == quads) return;
  out.clear(blocks);
  const int log = ceil_log2(quads);
  for (int u = 0; u < blocks; ++u) {
    const int quad = boundary(u, quads, log);
    if (quad == boundary(u + 1, quads, log)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      out.low[axis][u] = quad_row_.low[axis][quad];
      out.high[axis][u] = quad_row_.high[axis][quad];
      out.centre[axis][u] = quad_row_.centre[axis][quad];
    }
    out.radius[u] = quad_row_.radius[quad];
  }
}

// Boxes and spheres of a row of single quads, between two rows of vertices.
template <int ends>
void Pyramid::bound_quads(const VertexRow& upper, const VertexRow& lower, int quads,
                          BlockRow& out) {
  const QuadCorners<ends> corners{points(upper[0]), points(lower[0]), points(upper[ends - 1]),
                                  points(lower[ends - 1])};
  const BlockRowView<float> target = view(out);
#pragma omp simd
  for (int i = 0; i < quads; ++i) bound_quad(corners, i, target);
}

// Sets the spheres of a finished row of blocks, and every row above that it completes.
void Pyramid::finish_row(int patch, int level, int v) {
  for (;; --level) {
    const Level& here = level_of(patch, level);
    const BlockRow& row = block_rows_[level][v & 1];
    const int blocks = 1 << here.log_u;
    Sphere* spheres = &spheres_[here.first + (static_cast<std::size_t>(v) << here.log_u)];
    for (int u = 0; u < blocks; ++u) {
      spheres[u] = {row.centre[0][u], row.centre[1][u], row.centre[2][u], row.radius[u]};
    }
    if (level == 0) break;
    const Level& above = level_of(patch, level - 1);
    const bool split_v = above.log_v < here.log_v;
    if (split_v && v % 2 == 0) return;
    // Where the axis is not split the row has no partner but itself.
    const BlockRow& partner = split_v ? block_rows_[level][0] : row;
    if (split_v) v /= 2;
    BlockRow& out = block_rows_[level - 1][v & 1];
    if (above.log_u < here.log_u) {
      merge_rows<true>(partner, row, 1 << above.log_u, out);
    } else {
      merge_rows<false>(partner, row, 1 << above.log_u, out);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    patch_boxes_[patch].low[axis] = block_rows_[0][0].low[axis][0];
    patch_boxes_[patch].high[axis] = block_rows_[0][0].high[axis][0];
  }
}

// A row of parents from the two rows of their children.
template <bool split_u>
void Pyramid::merge_rows(const BlockRow& upper, const BlockRow& lower, int blocks, BlockRow& out) {
  const BlockRowView<const float> up = view(upper);
  const BlockRowView<const float> down = view(lower);
  const BlockRowView<float> target = view(out);
#pragma omp simd
  for (int i = 0; i < blocks; ++i) merge_blocks<split_u>(up, down, i, target);
}

// The carried-up radii are loosest at the top (by up to 44 % on a torus), where there are so few
// blocks that each can be bounded from its descendants three levels down.
void Pyramid::tighten_top_levels(int patch) {
  constexpr int down = 3;
  constexpr int top_levels = 4;
  for (int level = std::min(top_levels, levels(patch) - down) - 1; level >= 0; --level) {
    const Level& here = level_of(patch, level);
    const Level& below = level_of(patch, level + down);
    const int shift_u = below.log_u - here.log_u;
    const int shift_v = below.log_v - here.log_v;
    for (std::size_t i = 0; i < std::size_t{1} << (here.log_u + here.log_v); ++i) {
      Sphere& parent = spheres_[here.first + i];
      const auto u = static_cast<int>(i & ((std::size_t{1} << here.log_u) - 1));
      const auto v = static_cast<int>(i >> here.log_u);
      float reach = -1;
      for (int row = v << shift_v; row < (v + 1) << shift_v; ++row) {
        for (int col = u << shift_u; col < (u + 1) << shift_u; ++col) {
          const Sphere& child = sphere(patch, level + down, col, row);
          if (child.radius < 0) continue;
          reach = larger(reach, centre_distance(parent, child) + child.radius);
        }
      }
      if (reach >= 0) parent.radius = smaller(parent.radius, reach * round_up + radius_floor);
    }
  }
}

void Pyramid::rebuild_groups() {
  for (int level = group_levels_ - 1; level >= 0; --level) {
    for (int index = 0; index < 1 << level; ++index) {
      const auto [begin, end] = patches_of_group(level, index);
      const auto side = [&, begin = begin, end = end](int axis) {
        const auto of = [&](int patch) {
          return Interval{patch_boxes_[patch].low[axis], patch_boxes_[patch].high[axis]};
        };
        Interval whole = of(begin);
        for (int patch = begin + 1; patch < end; ++patch) whole = join(whole, of(patch));
        return whole;
      };
      const Interval x = side(0);
      const Interval y = side(1);
      const Interval z = side(2);
      Sphere bound{x.middle(), y.middle(), z.middle(), 0};
      float reach = 0;
      for (int patch = begin; patch < end; ++patch) {
        const Sphere& top_of_patch = sphere(patch, 0, 0, 0);
        reach = larger(reach, centre_distance(bound, top_of_patch) + top_of_patch.radius);
      }
      bound.radius = smaller(cover(half_diagonal(x, y, z), magnitude(x, y, z)),
                             reach * round_up + radius_floor);
      spheres_[first_group_ + (std::size_t{1} << level) - 1 + index] = bound;
    }
  }
}

// Replaces the radii of the fast build, from the bottom up: exact radii below prune best.
void Pyramid::refine_to_exact() {
  for (int patch = 0; patch < patch_count(); ++patch) {
    for (int level = levels(patch) - 2; level >= 0; --level) {
      const Level& place = level_of(patch, level);
      Sphere* target = &spheres_[place.first];
      for (int v = 0; v < 1 << place.log_v; ++v) {
        for (int u = 0; u < 1 << place.log_u; ++u, ++target) {
          if (target->radius >= 0) target->radius = exact_radius({patch, level, u, v});
        }
      }
    }
  }
  for (int level = group_levels_ - 1; level >= 0; --level) {
    Sphere* target = &spheres_[first_group_ + (std::size_t{1} << level) - 1];
    for (int u = 0; u < 1 << level; ++u, ++target) {
      target->radius = exact_radius({Block::group, level, u, 0});
    }
  }
}

float Pyramid::exact_radius(const Block& block) {
  const double squared = squared_reach(block, centre_of(sphere(block)));
  // float64 rounds by far less than 2^-40 here; the cast may round down, the next number up cannot.
  const auto rounded = static_cast<float>(std::sqrt(squared) * (1 + 0x1p-40));
  return larger(std::nextafter(rounded, empty_corner), radius_floor);
}

// Square of the largest distance from the centre to a vertex of the block. Descends only into
// blocks whose spheres reach farther than the farthest vertex found so far, starting with the
// corners of the block, which are the farthest vertices of most.
double Pyramid::squared_reach(const Block& block, const Vec3& centre) {
  double squared = 0;
  if (block.patch != Block::group) {
    const QuadRange range = quads(block);
    if (is_small(range)) return squared_reach_of_vertices(block.patch, range, 1, 1, centre);
    squared = squared_reach_of_vertices(block.patch, range, range.row_end - range.row_begin,
                                        range.col_end - range.col_begin, centre);
  }
  pending_.assign(1, block);
  while (!pending_.empty()) {
    const Block next = pending_.back();
    pending_.pop_back();
    if (next.patch != Block::group && is_small(quads(next))) {
      squared = std::max(squared, squared_reach_of_vertices(next.patch, quads(next), 1, 1, centre));
      continue;
    }
    std::array<Block, 4> child;
    const int count = children(next, child);
    const double found = std::sqrt(squared);
    for (int i = 0; i < count; ++i) {
      const Sphere& bound = sphere(child[i]);
      const double spare = found - static_cast<double>(bound.radius);
      if (spare > 0 && (centre_of(bound) - centre).squaredNorm() <= spare * spare) continue;
      pending_.push_back(child[i]);
    }
  }
  return squared;
}

// Of every row_step-th row and col_step-th column of vertices of a range of quads.
double Pyramid::squared_reach_of_vertices(int patch, const QuadRange& range, int row_step,
                                          int col_step, const Vec3& centre) const {
  const Patch& size = atlas_.patches()[patch];
  const bool direct = atlas_.is_identity() && end_count_ == 1;
  double squared = 0;
  for (int row = range.row_begin; row <= range.row_end; row += row_step) {
    const int first = atlas_.first_texel(patch) + (row < size.rows ? row : 0) * size.cols;
    for (int col = range.col_begin; col <= range.col_end; col += col_step) {
      const int texel = first + (col < size.cols ? col : 0);
      if (direct) {
        squared = std::max(squared, (ends_[0][texel] - centre).squaredNorm());
        continue;
      }
      const int particle = atlas_.particle_of_texel(texel);
      for (int end = 0; end < end_count_; ++end) {
        squared = std::max(squared, (ends_[end][particle] - centre).squaredNorm());
      }
    }
  }
  return squared;
}

}  // namespace weft::bsi
