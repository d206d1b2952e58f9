#include "bsi/pyramid.h"

#include <omp.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "bsi/detail/patch_order.h"
#include "bsi/detail/team.h"
#include "bsi/kernels/box_build_kernels.h"
#include "bsi/kernels/vertex_kernels.h"

namespace weft::bsi {

namespace {

// Rows are padded to a multiple of this number of floats, so that vector stores stay within a row.
constexpr std::size_t row_alignment = plane_padding;

std::size_t aligned(std::size_t count) {
  return (count + row_alignment - 1) / row_alignment * row_alignment;
}

std::size_t blocks_along(int log) { return std::size_t{1} << log; }

// Patches with fewer quads are not split into strips.
constexpr int least_quads_per_thread = 1 << 13;
// Base-2 logarithm of the largest number of strips of a patch.
constexpr int strip_log_limit = 4;

Box join(Box a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    a.low[axis] = std::min(a.low[axis], b.low[axis]);
    a.high[axis] = std::max(a.high[axis], b.high[axis]);
  }
  return a;
}

}  // namespace

Pyramid::Pyramid(const Atlas& atlas, const PyramidParts& parts) : atlas_(atlas), parts_(parts) {
  const int patches = static_cast<int>(atlas.patches().size());
  if (patches == 0) throw std::invalid_argument("the atlas has no patches");
  for (int patch = 0; patch < patches; ++patch) add_patch(patch);
  for (int patch = 0; patch < patches; ++patch) add_strips(patch);
  // Kernels may read past the end of the last row.
  vertices_[0].resize(vertices_[0].size() + row_alignment);
  group_levels_ = group_levels_above(patches);
  patch_order_.resize(patches);
  std::iota(patch_order_.begin(), patch_order_.end(), 0);
  group_boxes_.resize((std::size_t{1} << group_levels_) - 1);
  point_views();
}

void Pyramid::add_patch(int patch) {
  const Patch& image = atlas_.patches()[patch];
  if (std::min(image.quad_rows(), image.quad_cols()) < 1)
    throw std::invalid_argument("patch " + std::to_string(patch) + " has no quads");
  if (std::max(image.quad_rows(), image.quad_cols()) > quad_limit) {
    throw std::invalid_argument("patch " + std::to_string(patch) + " has more than " +
                                std::to_string(quad_limit) + " quads along an axis");
  }
  const int depth_u = std::max(0, ceil_log2(image.quad_cols()) - 1);
  const int depth_v = std::max(0, ceil_log2(image.quad_rows()) - 1);
  const int leaf_level = std::max(depth_u, depth_v);
  BoxPatch view{};
  view.quad_rows = image.quad_rows();
  view.quad_cols = image.quad_cols();
  view.wrap_u = image.wrap_u ? 1 : 0;
  view.wrap_v = image.wrap_v ? 1 : 0;
  view.rows = image.rows;
  view.cols = image.cols;
  view.first_quad = atlas_.first_quad(patch);
  view.first_texel = atlas_.first_texel(patch);
  view.first_level = static_cast<int>(levels_.size());
  view.level_count = leaf_level + 1;
  std::size_t groups = groups_.size(), tangents = tangents_.size();
  for (int level = 0; level <= leaf_level; ++level) {
    BoxLevel place{};
    place.log_u = std::min(level, depth_u);
    place.log_v = std::min(level, depth_v);
    place.split_u = level < depth_u ? 1 : 0;
    place.split_v = level < depth_v ? 1 : 0;
    place.patch = patch;
    places_.push_back({groups, tangents});
    levels_.push_back(place);
    if (level == leaf_level) break;
    groups += blocks_along(place.log_u + place.log_v);
    if (parts_.tangents) tangents += blocks_along(place.log_u + place.log_v);
  }
  groups_.resize(groups);
  tangents_.resize(tangents);
  if (parts_.spheres) spheres_.resize(groups);
  first_vertex_.push_back(vertices_[0].size());
  const std::size_t stride = aligned(static_cast<std::size_t>(image.quad_cols()) + 1 + 4);
  view.vertices[0].stride = view.vertices[1].stride = stride;
  vertices_[0].resize(vertices_[0].size() +
                      3 * stride * (static_cast<std::size_t>(image.quad_rows()) + 1));
  first_boundary_.push_back(boundaries_.size());
  for (int u = 0; u <= 1 << depth_u; ++u) {
    boundaries_.push_back(block_boundary(u, image.quad_cols(), depth_u));
  }
  patches_.push_back(view);
}

void Pyramid::add_strips(int patch) {
  const BoxPatch& view = patches_[patch];
  const BoxLevel& leaves = level_of(patch, levels(patch) - 1);
  const bool parallel = view.quad_rows * view.quad_cols >= least_quads_per_thread;
  // A strip consists of whole rows of the parents of leaf blocks.
  strip_log_.push_back(parallel ? std::clamp(leaves.log_v - 1, 0, strip_log_limit) : 0);
  for (int index = 0; index < 1 << strip_log_[patch]; ++index) {
    Strip strip;
    strip.patch = patch;
    strip.index = index;
    std::size_t size = 0;
    for (int level = 0; level < levels(patch); ++level) {
      strip.row.push_back(size);
      size += 2 * plane_count * aligned(blocks_along(level_of(patch, level).log_u));
    }
    strip.columns = size;
    strip.rows.resize(size + plane_count * view.vertices[0].stride + row_alignment);
    strip.boundary[0].resize(3 * view.vertices[0].stride + row_alignment);
    strips_.push_back(std::move(strip));
  }
}

// Sets the pointers in levels_, patches_ and tree_. They stay valid when the pyramid is moved,
// because moving a vector keeps its array in place.
void Pyramid::point_views() {
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    const bool leaf = i + 1 == levels_.size() || levels_[i].patch != levels_[i + 1].patch;
    levels_[i].groups = leaf ? nullptr : &groups_[places_[i].groups];
    levels_[i].tangents = leaf || !parts_.tangents ? nullptr : &tangents_[places_[i].tangents];
    levels_[i].spheres = leaf || !parts_.spheres ? nullptr : &spheres_[places_[i].groups];
  }
  for (int patch = 0; patch < patch_count(); ++patch) {
    BoxPatch& view = patches_[patch];
    const std::size_t plane =
        view.vertices[0].stride * (static_cast<std::size_t>(view.quad_rows) + 1);
    for (int end = 0; end < 2; ++end) {
      const std::vector<float>& all = vertices_[end].empty() ? vertices_[0] : vertices_[end];
      for (int axis = 0; axis < 3; ++axis) {
        view.vertices[end].component[axis] = &all[first_vertex_[patch] + axis * plane];
      }
    }
  }
  tree_.levels = levels_.data();
  tree_.patches = patches_.data();
  tree_.texel_to_particle = atlas_.is_identity() ? nullptr : atlas_.texel_to_particle().data();
}

QuadRange Pyramid::quads(int patch, int level, int u, int v) const {
  const BoxLevel& place = level_of(patch, level);
  const BoxPatch& image = patches_[patch];
  return {block_boundary(v, image.quad_rows, place.log_v),
          block_boundary(v + 1, image.quad_rows, place.log_v),
          block_boundary(u, image.quad_cols, place.log_u),
          block_boundary(u + 1, image.quad_cols, place.log_u)};
}

Pyramid::ChildPlace Pyramid::child_place(int patch, int level, int u, int v) const {
  const BoxLevel& above = level_of(patch, level - 1);
  return {(static_cast<std::size_t>(v >> above.split_v) << above.log_u) + (u >> above.split_u),
          2 * (above.split_v * (v & 1)) + above.split_u * (u & 1)};
}

Box Pyramid::box(int patch, int level, int u, int v) const {
  Box result;
  if (level == 0) {
    const BoxPatch& whole = patches_[patch];
    std::copy_n(whole.low, 3, result.low.begin());
    std::copy_n(whole.high, 3, result.high.begin());
    return result;
  }
  const BoxLevel& above = level_of(patch, level - 1);
  const auto [parent, child] = child_place(patch, level, u, v);
  for (int axis = 0; axis < 3; ++axis) {
    result.low[axis] = above.groups[parent].low[axis][child];
    result.high[axis] = above.groups[parent].high[axis][child];
  }
  return result;
}

std::size_t Pyramid::bytes() const {
  std::size_t floats = vertices_[0].size() + vertices_[1].size();
  for (const Strip& strip : strips_) {
    floats += strip.rows.size() + strip.boundary[0].size() + strip.boundary[1].size();
  }
  return sizeof(float) * floats + sizeof(BoxGroup) * groups_.size() +
         sizeof(TangentBounds) * tangents_.size() + sizeof(SphereGroup) * spheres_.size() +
         sizeof(Box) * group_boxes_.size() + sizeof(std::int32_t) * boundaries_.size();
}

std::optional<TexelAddress> Pyramid::rebuild(std::span<const Vec3> positions, int threads) {
  ends_ = {positions, positions};
  return rebuild_all(1, threads);
}

std::optional<TexelAddress> Pyramid::rebuild_swept(std::span<const Vec3> start,
                                                   std::span<const Vec3> end, int threads) {
  ends_ = {start, end};
  if (vertices_[1].empty()) {
    vertices_[1].resize(vertices_[0].size());
    for (Strip& strip : strips_) strip.boundary[1].resize(strip.boundary[0].size());
    point_views();
  }
  return rebuild_all(2, threads);
}

std::optional<TexelAddress> Pyramid::rebuild_all(int ends, int threads) {
  for (const auto& end : ends_) {
    assert(static_cast<int>(end.size()) == atlas_.particle_count());
    static_cast<void>(end);
  }
  built_ = false;
  tree_.swept = ends - 1;
  const int strips = static_cast<int>(strips_.size());
  const int team = std::min(strips, threads > 0 ? threads : omp_get_max_threads());
  SharedCount next(strips);
  run_team(team, [&] {
    for (int i = 0; next.take(i);) rebuild_strip(strips_[i]);
  });
  const bool finite =
      std::all_of(strips_.begin(), strips_.end(), [](const Strip& s) { return s.finite; });
  if (!finite) return first_unbounded();
  std::size_t first = 0;
  for (int patch = 0; patch < patch_count(); ++patch) {
    const std::size_t count = blocks_along(strip_log_[patch]);
    join_strips(std::span(strips_).subspan(first, count));
    first += count;
    if (parts_.spheres) rebuild_spheres(patch, threads);
  }
  rebuild_groups();
  ends_ = {};
  built_ = true;
  return std::nullopt;
}

// Rounds the vertices of a strip to float32 and bounds its blocks, one row of leaf blocks after
// another. A row of parents is built as soon as its rows of children exist, while these are in the
// cache.
void Pyramid::rebuild_strip(Strip& strip) {
  const BoxPatch& image = patches_[strip.patch];
  const int leaf_level = levels(strip.patch) - 1;
  const BoxLevel& leaves = level_of(strip.patch, leaf_level);
  const int rows_log = leaves.log_v - strip_log_[strip.patch];
  const int first = strip.index << rows_log;
  const int last = (strip.index + 1) << rows_log;
  const auto boundary = [&](int v) { return block_boundary(v, image.quad_rows, leaves.log_v); };
  strip.finite = true;
  for (int end = 0; end <= tree_.swept; ++end) {
    strip.finite = load_row(strip, boundary(first), end) && strip.finite;
  }
  for (int v = first; v < last; ++v) {
    for (int end = 0; end <= tree_.swept; ++end) {
      for (int row = boundary(v) + 1; row <= boundary(v + 1); ++row) {
        strip.finite = load_row(strip, row, end) && strip.finite;
      }
    }
    bound_leaf_row(strip, v);
    finish_row(strip, v);
  }
}

void Pyramid::bound_leaf_row(Strip& strip, int v) {
  const BoxBuildKernels& kernels = box_build_kernels();
  const BoxPatch& image = patches_[strip.patch];
  const int level = levels(strip.patch) - 1;
  const QuadRange rows = quads(strip.patch, level, 0, v);
  const BoundRow columns{&strip.rows[strip.columns], image.vertices[0].stride};
  for (int end = 0; end <= tree_.swept; ++end) {
    kernels.bound_columns(vertex_rows(strip, rows.row_begin, rows.row_end, end), image.quad_cols,
                          end > 0, columns);
  }
  kernels.bound_leaves(columns, box_planes, &boundaries_[first_boundary_[strip.patch]],
                       blocks_u(strip.patch, level), row(strip, level, v));
}

// Bounds the steps in row v of the parents of leaf blocks, the finest level with bounds of steps.
// The kernels combine the steps by column of vertices, then by column of leaf blocks, then by
// column of parents.
void Pyramid::bound_step_row(Strip& strip, int v, BoundRow out) {
  const BoxBuildKernels& kernels = box_build_kernels();
  const BoxPatch& image = patches_[strip.patch];
  const int level = levels(strip.patch) - 2;
  const QuadRange rows = quads(strip.patch, level, 0, v);
  const BoundRow columns{&strip.rows[strip.columns], image.vertices[0].stride};
  for (int end = 0; end <= tree_.swept; ++end) {
    kernels.bound_steps(vertex_rows(strip, rows.row_begin, rows.row_end, end), image.quad_cols,
                        end > 0, columns);
  }
  const BoundRow leaves = row(strip, level + 1, 0);
  kernels.bound_leaves(columns, step_planes, &boundaries_[first_boundary_[strip.patch]],
                       blocks_u(strip.patch, level + 1), leaves);
  kernels.merge(leaves, leaves, step_planes, level_of(strip.patch, level).split_u != 0,
                blocks_u(strip.patch, level), out);
}

// Rounds row `row` of the vertices at one end of their paths to float32. Returns false if a vertex
// is not finite. On a wrapped axis, the row after the last repeats row 0. A strip also stores the
// first row of the next strip.
bool Pyramid::load_row(Strip& strip, int row, int end) {
  const BoxPatch& image = patches_[strip.patch];
  const VertexRows place = vertex_rows(strip, row, row, end);
  std::array<float*, 3> component{};
  for (int axis = 0; axis < 3; ++axis) component[axis] = const_cast<float*>(place.row[0][axis]);
  const std::size_t texel = static_cast<std::size_t>(image.first_texel) +
                            static_cast<std::size_t>(row < image.rows ? row : 0) * image.cols;
  const bool identity = tree_.texel_to_particle == nullptr;
  const double* positions = ends_[end].data()->data() + (identity ? 3 * texel : 0);
  const std::int32_t* particle = identity ? nullptr : tree_.texel_to_particle + texel;
  const bool finite =
      vertex_kernels().load(positions, particle, image.cols, coordinate_limit, component.data());
  if (image.wrap_u != 0) {
    for (float* values : component) values[image.cols] = values[0];
  }
  return finite;
}

VertexRows Pyramid::vertex_rows(const Strip& strip, int first_row, int last_row, int end) const {
  const BoxPatch& image = patches_[strip.patch];
  const BoxLevel& leaves = level_of(strip.patch, levels(strip.patch) - 1);
  const int strips_log = strip_log_[strip.patch];
  const int next_strip = block_boundary((strip.index + 1) << (leaves.log_v - strips_log),
                                        image.quad_rows, leaves.log_v);
  const std::size_t stride = image.vertices[end].stride;
  VertexRows rows{};
  rows.count = last_row - first_row + 1;
  for (int row = first_row; row <= last_row; ++row) {
    const bool shared = row == next_strip && row != image.quad_rows;
    for (int axis = 0; axis < 3; ++axis) {
      rows.row[row - first_row][axis] = shared ? &strip.boundary[end][axis * stride]
                                               : image.vertices[end].component[axis] + row * stride;
    }
  }
  return rows;
}

// Returns the memory for row v of a level. Rows v and v + 1 have separate memory on levels where
// the strip has several rows of blocks.
BoundRow Pyramid::row(Strip& strip, int level, int v) const {
  const std::size_t stride = aligned(blocks_along(level_of(strip.patch, level).log_u));
  const std::size_t second = level > strip_log_[strip.patch] ? v & 1 : 0;
  return {&strip.rows[strip.row[level] + second * plane_count * stride], stride};
}

// Builds the rows of parents that are complete once row v of leaf blocks exists, up to the level on
// which the strip is one row.
void Pyramid::finish_row(Strip& strip, int v) {
  const int top = strip_log_[strip.patch];
  for (int level = levels(strip.patch) - 1; level > top; --level) {
    const bool split = level_of(strip.patch, level - 1).split_v != 0;
    if (split && v % 2 == 0) return;
    if (split) v /= 2;
    const BoundRow upper = row(strip, level, split ? 2 * v : v);
    const BoundRow lower = split ? row(strip, level, 2 * v + 1) : BoundRow{nullptr, 0};
    const BoundRow out = row(strip, level - 1, v);
    merge_into_parent(strip.patch, level - 1, upper, lower, v, out);
    if (!parts_.tangents) continue;
    if (level == levels(strip.patch) - 1) bound_step_row(strip, v, out);
    store_tangents(strip.patch, level - 1, v, out);
  }
}

// Builds the levels above those that each strip builds by itself. A row of blocks is stored in the
// first strip below it.
void Pyramid::join_strips(std::span<Strip> strips) {
  const int patch = strips[0].patch;
  const int top = strip_log_[patch];
  for (int level = top - 1; level >= 0; --level) {
    const auto of = [&](int at, int v) { return row(strips[v << (top - at)], at, v); };
    for (int v = 0; v < 1 << level; ++v) {
      merge_into_parent(patch, level, of(level + 1, 2 * v), of(level + 1, 2 * v + 1), v,
                        of(level, v));
      if (parts_.tangents) store_tangents(patch, level, v, of(level, v));
    }
  }
  const BoundRow whole = row(strips[0], 0, 0);
  for (int axis = 0; axis < 3; ++axis) {
    patches_[patch].low[axis] = -whole.plane[axis * whole.stride];
    patches_[patch].high[axis] = whole.plane[(3 + axis) * whole.stride];
  }
}

// Builds row v of a level from one or two rows of its children. If the level is not split along v,
// there is one row, and lower.plane is null.
void Pyramid::merge_into_parent(int patch, int level, BoundRow upper, BoundRow lower, int v,
                                BoundRow out) {
  const BoxBuildKernels& kernels = box_build_kernels();
  const BoxLevel& parent = level_of(patch, level);
  const int blocks = 1 << parent.log_u;
  const std::size_t first = static_cast<std::size_t>(v) << parent.log_u;
  BoxGroup* groups = &groups_[places_[patches_[patch].first_level + level].groups + first];
  kernels.store_groups(upper, lower, parent.split_u != 0, blocks, groups);
  // Leaf blocks have no bounds of steps that their parents could merge.
  const bool steps = parts_.tangents && level < levels(patch) - 2;
  const PlaneRange planes{0, steps ? step_planes.end : box_planes.end};
  kernels.merge(upper, lower.plane != nullptr ? lower : upper, planes, parent.split_u != 0, blocks,
                out);
}

void Pyramid::store_tangents(int patch, int level, int v, BoundRow bounds) {
  const BoxLevel& place = level_of(patch, level);
  const std::size_t first = static_cast<std::size_t>(v) << place.log_u;
  TangentBounds* tangents =
      &tangents_[places_[patches_[patch].first_level + level].tangents + first];
  box_build_kernels().store_tangents(bounds, 1 << place.log_u, tangents);
}

TexelAddress Pyramid::first_unbounded() const {
  for (int texel = 0;; ++texel) {
    assert(texel < atlas_.texel_count());
    for (int end = 0; end <= tree_.swept; ++end) {
      const Eigen::Vector3f rounded = ends_[end][atlas_.particle_of_texel(texel)].cast<float>();
      // NaN fails this comparison; a maximum would drop NaN.
      if (!(rounded.array().abs() < coordinate_limit).all()) return atlas_.texel_address(texel);
    }
  }
}

// At the first successful rebuild, orders the patches by position, so that groups consist of nearby
// patches.
void Pyramid::order_patches() {
  if (is_ordered_) return;
  is_ordered_ = true;
  std::vector<std::array<float, 3>> places;  // twice the centre of each patch
  for (const BoxPatch& patch : patches_) {
    places.push_back(
        {patch.low[0] + patch.high[0], patch.low[1] + patch.high[1], patch.low[2] + patch.high[2]});
  }
  patch_order_ = order_by_place(places);
}

void Pyramid::rebuild_groups() {
  order_patches();
  for (int level = 0; level < group_levels_; ++level) {
    for (int u = 0; u < 1 << level; ++u) {
      const auto patches = patches_of_group(level, u);
      Box whole = box(patches[0], 0, 0, 0);
      for (const int patch : patches.subspan(1)) whole = join(whole, box(patch, 0, 0, 0));
      group_boxes_[(std::size_t{1} << level) - 1 + u] = whole;
    }
  }
  const Box whole = top();
  tree_.magnitude = 0;
  for (int axis = 0; axis < 3; ++axis) {
    tree_.magnitude = std::max({tree_.magnitude, -whole.low[axis], whole.high[axis]});
  }
}

}  // namespace weft::bsi
