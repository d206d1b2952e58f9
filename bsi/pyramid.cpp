#include "bsi/pyramid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "bsi/sphere_bounds.h"

namespace weft::bsi {

namespace {

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

Pyramid::Pyramid(const Atlas& atlas, RadiusPolicy policy)
    : atlas_(atlas), policy_(policy), numbers_(atlas) {
  for (int patch = 0; patch < patch_count(); ++patch) reserve_rows(patch);
  patch_boxes_.resize(patch_count());
  spheres_.resize(numbers_.block_count() + (std::size_t{1} << group_levels()) - 1);
  // A descent leaves at most three siblings behind on each level.
  pending_.reserve(3 * (block_rows_.size() + group_levels()) + 4);
}

void Pyramid::reserve_rows(int patch) {
  block_rows_.resize(std::max(block_rows_.size(), static_cast<std::size_t>(levels(patch))));
  for (int level = 0; level < levels(patch); ++level) {
    for (BlockRow& row : block_rows_[level]) row.reserve(blocks_u(patch, level));
  }
  const int cols = atlas_.patches()[patch].quad_cols();
  quad_row_.reserve(cols);
  const std::size_t vertices = static_cast<std::size_t>(cols) + 1;
  for (VertexRow& row : vertex_rows_) {
    for (auto& end : row) {
      for (auto& component : end) component.resize(std::max(component.size(), vertices));
    }
  }
}

std::span<const Sphere> Pyramid::level_spheres(int patch, int level) const {
  const BlockLevel& place = numbers_.at(patch, level);
  return std::span(spheres_).subspan(place.first, place.count());
}

std::span<const Sphere> Pyramid::group_spheres(int level) const {
  const std::size_t count = std::size_t{1} << level;
  return std::span(spheres_).subspan(numbers_.block_count() + count - 1, count);
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
  if (block.patch == Block::group && next < group_levels()) {
    // Every one of these groups has a patch: there are more patches than groups.
    child[0] = {Block::group, next, 2 * block.u, 0};
    child[1] = {Block::group, next, 2 * block.u + 1, 0};
    return 2;
  }
  if (block.patch == Block::group) {
    const auto [begin, end] = numbers_.patches_of_group(block.level, block.u);
    for (int patch = begin; patch < end; ++patch) child[patch - begin] = {patch, 0, 0, 0};
    return end - begin;
  }
  const BlockLevel& here = numbers_.at(block.patch, block.level);
  const BlockLevel& below = numbers_.at(block.patch, next);
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
  const auto place = rebuild_all();
  ends_ = {};
  return place;
}

std::optional<TexelAddress> Pyramid::rebuild_swept(std::span<const Vec3> start,
                                                   std::span<const Vec3> end) {
  ends_ = {start, end};
  end_count_ = 2;
  const auto place = rebuild_all();
  ends_ = {};
  return place;
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
  const BlockLevel& leaves = numbers_.at(patch, leaf_level);
  const int blocks = 1 << leaves.log_u;
  const auto load = [&](int row) {
    VertexRow& vertices = vertex_rows_[row & 1];
    const int texel_row = row < size.rows ? row : 0;
    return end_count_ == 1 ? load_row<1>(patch, texel_row, vertices)
                           : load_row<2>(patch, texel_row, vertices);
  };
  if (!load(0)) return first_unbounded(patch, 0);
  for (int v = 0; v < 1 << leaves.log_v; ++v) {
    const int quad_row = block_boundary(v, size.quad_rows(), leaves.log_v);
    BlockRow& out = block_rows_[leaf_level][v & 1];
    if (quad_row == block_boundary(v + 1, size.quad_rows(), leaves.log_v)) {
      out.clear(blocks);
    } else {
      if (!load(quad_row + 1)) return first_unbounded(patch, quad_row + 1);
      const VertexRow& upper = vertex_rows_[quad_row & 1];
      const VertexRow& lower = vertex_rows_[(quad_row + 1) & 1];
      // Where the quads are a power of two in number they are the blocks.
      BlockRow& bounded = blocks == size.quad_cols() ? out : quad_row_;
      bound_quads(upper, lower, end_count_, size.quad_cols(), bounded);
      if (&bounded != &out) spread_quads(bounded, size.quad_cols(), blocks, out);
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

// Sets the spheres of a finished row of blocks, and every row above that it completes.
void Pyramid::finish_row(int patch, int level, int v) {
  for (;; --level) {
    const BlockLevel& here = numbers_.at(patch, level);
    const BlockRow& row = block_rows_[level][v & 1];
    const int blocks = 1 << here.log_u;
    Sphere* spheres = &spheres_[here.block(0, v)];
    for (int u = 0; u < blocks; ++u) {
      spheres[u] = {row.centre[0][u], row.centre[1][u], row.centre[2][u], row.radius[u]};
    }
    if (level == 0) break;
    const BlockLevel& above = numbers_.at(patch, level - 1);
    const bool split_v = above.log_v < here.log_v;
    if (split_v && v % 2 == 0) return;
    // Where the axis is not split the row has no partner but itself.
    const BlockRow& partner = split_v ? block_rows_[level][0] : row;
    if (split_v) v /= 2;
    BlockRow& out = block_rows_[level - 1][v & 1];
    merge_rows(partner, row, above.log_u < here.log_u, 1 << above.log_u, out);
  }
  for (int axis = 0; axis < 3; ++axis) {
    patch_boxes_[patch].low[axis] = block_rows_[0][0].low[axis][0];
    patch_boxes_[patch].high[axis] = block_rows_[0][0].high[axis][0];
  }
}

// The carried-up radii are loosest at the top (by up to 44 % on a torus), where there are so few
// blocks that each can be bounded from its descendants three levels down.
void Pyramid::tighten_top_levels(int patch) {
  constexpr int down = 3;
  constexpr int top_levels = 4;
  for (int level = std::min(top_levels, levels(patch) - down) - 1; level >= 0; --level) {
    const BlockLevel& here = numbers_.at(patch, level);
    const BlockLevel& below = numbers_.at(patch, level + down);
    const int shift_u = below.log_u - here.log_u;
    const int shift_v = below.log_v - here.log_v;
    for (std::size_t i = 0; i < here.count(); ++i) {
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
      if (reach >= 0) parent.radius = smaller(parent.radius, carry(reach));
    }
  }
}

void Pyramid::rebuild_groups() {
  for (int level = group_levels() - 1; level >= 0; --level) {
    for (int index = 0; index < 1 << level; ++index) {
      const auto [begin, end] = numbers_.patches_of_group(level, index);
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
      bound.radius = smaller(cover(half_diagonal(x, y, z), magnitude(x, y, z)), carry(reach));
      spheres_[numbers_.block_count() + (std::size_t{1} << level) - 1 + index] = bound;
    }
  }
}

// Replaces the radii of the fast build, from the bottom up: exact radii below prune best.
void Pyramid::refine_to_exact() {
  for (int patch = 0; patch < patch_count(); ++patch) {
    for (int level = levels(patch) - 2; level >= 0; --level) {
      const BlockLevel& place = numbers_.at(patch, level);
      Sphere* target = &spheres_[place.first];
      for (int v = 0; v < 1 << place.log_v; ++v) {
        for (int u = 0; u < 1 << place.log_u; ++u, ++target) {
          if (target->radius >= 0) target->radius = exact_radius({patch, level, u, v});
        }
      }
    }
  }
  for (int level = group_levels() - 1; level >= 0; --level) {
    Sphere* target = &spheres_[numbers_.block_count() + (std::size_t{1} << level) - 1];
    for (int u = 0; u < 1 << level; ++u, ++target) {
      target->radius = exact_radius({Block::group, level, u, 0});
    }
  }
}

float Pyramid::exact_radius(const Block& block) {
  const double squared = squared_reach(block, centre_of(sphere(block)));
  // float64 rounds by far less than 2^-40 here; the cast may round down, the next number up cannot.
  const auto rounded = static_cast<float>(std::sqrt(squared) * (1 + 0x1p-40));
  return larger(std::nextafter(rounded, std::numeric_limits<float>::infinity()), radius_floor);
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
