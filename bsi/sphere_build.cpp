#include "bsi/sphere_build.h"

#include <omp.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "bsi/exact_radius.h"
#include "bsi/sphere_bounds.h"
#include "bsi/vertex_kernels.h"

namespace weft::bsi {

namespace {

// A patch of fewer quads is not split into strips, a body of fewer bounded by one thread.
constexpr int quads_worth_a_thread = 1 << 13;
constexpr int strip_log_limit = 4;
constexpr int planes = 7;  // of a row of blocks

// Floats of an array of a row. The odd line keeps arrays of 4096 bytes, the commonest length, off
// each other's places in the cache.
std::size_t padded(std::size_t count) { return (count + row_padding + 15) / 16 * 16 + 16; }

std::size_t blocks_along(int log) { return std::size_t{1} << log; }

SphereRow row_at(float* first, std::size_t stride) {
  return {{first, first + stride, first + 2 * stride},
          {first + 3 * stride, first + 4 * stride, first + 5 * stride},
          first + 6 * stride};
}

float length(float x, float y, float z) { return std::sqrt(x * x + y * y + z * z); }

// Of the inner sphere, seen from the centre of the outer one.
float reach_of(const Sphere& outer, const Sphere& inner) {
  return length(inner.x - outer.x, inner.y - outer.y, inner.z - outer.z) + inner.radius;
}

}  // namespace

SphereBuild::SphereBuild(const Atlas& atlas, const BlockLevels& numbers, RadiusPolicy policy)
    : is_parallel_(atlas.quad_count() >= quads_worth_a_thread),
      keeps_vertices_(policy != RadiusPolicy::fast) {
  patches_.resize(numbers.patch_count());
  for (int patch = 0; patch < numbers.patch_count(); ++patch) plan_patch(atlas, numbers, patch);
  int levels = 0, depth_u = 0;
  for (int patch = 0; patch < numbers.patch_count(); ++patch) {
    levels = std::max(levels, numbers.levels(patch));
    depth_u = std::max(depth_u, patches_[patch].depth_u);
  }
  for (int level = 0; level < levels; ++level) {
    level_row_.push_back(block_row_floats_);
    block_row_floats_ += 2 * planes * padded(blocks_along(std::min(level, depth_u)));
  }
}

void SphereBuild::plan_patch(const Atlas& atlas, const BlockLevels& numbers, int patch) {
  const Patch& image = atlas.patches()[patch];
  PatchPlan& plan = patches_[patch];
  const int levels = numbers.levels(patch);
  const BlockLevel& last = numbers.at(patch, levels - 1);
  plan.depth_u = last.log_u;
  plan.depth_v = last.log_v;
  const bool parallel = image.quad_count() >= quads_worth_a_thread;
  plan.strip_level = parallel ? std::clamp(plan.depth_v - 2, 0, strip_log_limit) : 0;
  for (int index = 0; index < 1 << plan.strip_level; ++index) strips_.push_back({patch, index});
  const auto tops = blocks_along(numbers.at(patch, plan.strip_level).log_u);
  plan.strip_tops.resize(planes * padded(tops) << plan.strip_level);
  plan.first_triangle = triangle_count_;
  triangle_count_ += 2 * last.count();
  plan.stride = padded(blocks_along(plan.depth_u) + 1);
  vertex_stride_ = std::max(vertex_stride_, plan.stride);
  if (keeps_vertices_) {
    plan.first_vertex = vertices_[0].size();
    vertices_[0].resize(plan.first_vertex + 3 * plan.stride * (image.quad_rows() + std::size_t{1}));
  }
  if (image.quad_cols() == 1 << plan.depth_u) return;
  for (int u = 0; u <= 1 << plan.depth_u; ++u) {
    const int column = block_boundary(u, image.quad_cols(), plan.depth_u);
    const bool repeated = u > 0 && column == plan.run_from.back() + plan.run_length.back() - 1;
    if (repeated) plan.empty_columns.push_back(u - 1);
    if (u == 0 || repeated) {
      plan.run_from.push_back(column);
      plan.run_length.push_back(0);
    }
    ++plan.run_length.back();
  }
}

void SphereBuild::make_scratch(int threads) {
  if (static_cast<int>(scratch_.size()) < threads) scratch_.resize(threads);
  for (Scratch& scratch : scratch_) {
    scratch.block_rows.resize(block_row_floats_);
    scratch.image_row.resize(3 * vertex_stride_);
    if (keeps_vertices_) {
      scratch.centres.resize(3 * vertex_stride_);
      scratch.squared.resize(vertex_stride_);
    }
    for (int end = 0; end < end_count_; ++end) {
      scratch.vertex_rows[end].resize(3 * vertex_stride_ * (keeps_vertices_ ? 1 : 4));
    }
  }
}

std::size_t SphereBuild::bytes() const {
  std::size_t floats = vertices_[0].size() + vertices_[1].size();
  for (const PatchPlan& plan : patches_) floats += plan.strip_tops.size();
  for (const Scratch& scratch : scratch_) {
    floats += scratch.block_rows.size() + scratch.image_row.size() + scratch.centres.size() +
              scratch.squared.size() + scratch.vertex_rows[0].size() +
              scratch.vertex_rows[1].size();
  }
  return floats * sizeof(float);
}

std::optional<TexelAddress> SphereBuild::run(const SphereTree& tree,
                                             std::span<const std::span<const Vec3>> ends,
                                             float limit, int threads) {
  tree_ = tree;
  limit_ = limit;
  end_count_ = static_cast<int>(ends.size());
  std::copy(ends.begin(), ends.end(), ends_.begin());
  if (keeps_vertices_ && end_count_ == 2) vertices_[1].resize(vertices_[0].size());
  const int strips = static_cast<int>(strips_.size());
  const int team = is_parallel_ && omp_in_parallel() == 0 ? std::min(strips, threads) : 1;
  make_scratch(team);
  bool bounded = true;
#pragma omp parallel for schedule(dynamic, 1) num_threads(team) reduction(&& : bounded) if (team > 1)
  for (int i = 0; i < strips; ++i) {
    bounded = bound_strip(strips_[i], scratch_[team > 1 ? omp_get_thread_num() : 0]) && bounded;
  }
  if (!bounded) return first_unbounded();
  for (int patch = 0; patch < static_cast<int>(patches_.size()); ++patch) {
    join_strips(patch);
    if (!keeps_vertices_) tighten_top_levels(patch);
  }
  bound_groups();
  return std::nullopt;
}

// Row after row of quads, two at a time where pairs of them have a parent; a parent's row is made
// as soon as those of its children are there, while they are still in the cache.
bool SphereBuild::bound_strip(const Strip& strip, Scratch& scratch) {
  const int patch = strip.patch;
  const PatchPlan& plan = patches_[patch];
  const int leaf_level = tree_.numbers->levels(patch) - 1;
  const int log = plan.depth_v - plan.strip_level;
  const int begin = strip.index << log, end = (strip.index + 1) << log;
  const bool in_pairs = log > 0 && tree_.numbers->at(patch, leaf_level - 1).log_v < plan.depth_v;
  const int step = in_pairs ? 2 : 1;
  const SphereVertices vertices = vertices_of_strip(patch, boundary_row(patch, end), scratch);
  int loaded = boundary_row(patch, begin) - 1;
  for (int v = begin; v < end; v += step) {
    SphereVertexRows rows{};
    rows.row_count = step + 1;
    rows.ends = end_count_;
    for (int k = 0; k <= step; ++k) {
      const int row = boundary_row(patch, v + k);
      if (row > loaded && !load_row(patch, row, vertices, scratch)) return false;
      loaded = row;
      for (int side = 0; side < end_count_; ++side) rows.row[side][k] = vertices.row(side, row);
    }
    bound_leaf_rows(patch, v, rows, scratch);
    for (int k = 0; k < step; ++k) {
      climb(patch, leaf_level, v + k, plan.strip_level, vertices, scratch);
    }
  }
  return true;
}

// The row of vertices above a row of blocks of the last level.
int SphereBuild::boundary_row(int patch, int v) const {
  return block_boundary(v, tree_.atlas->patches()[patch].quad_rows(), patches_[patch].depth_v);
}

// Where a strip that ends in row `last` finds its vertices. That row belongs to the next strip as
// well, which would write it at the same time; so it has a place of its own.
SphereVertices SphereBuild::vertices_of_strip(int patch, int last, Scratch& scratch) {
  SphereVertices vertices = kept_vertices(patch);
  for (int end = 0; end < end_count_; ++end) {
    AlignedVector<float>& rows = scratch.vertex_rows[end];
    if (!keeps_vertices_) {
      vertices.first[end] = rows.data();
      vertices.last_row[end] = rows.data() + 3 * vertices.stride * (last & vertices.row_mask);
    } else if (last < vertices.last) {
      vertices.last_row[end] = rows.data();
    }
  }
  vertices.last = last;
  return vertices;
}

// Those of the whole patch, where they are kept.
SphereVertices SphereBuild::kept_vertices(int patch) {
  SphereVertices vertices;
  vertices.last = tree_.atlas->patches()[patch].quad_rows();
  vertices.stride = patches_[patch].stride;
  vertices.ends = end_count_;
  vertices.row_mask = keeps_vertices_ ? -1 : 3;
  for (int end = 0; end < end_count_ && keeps_vertices_; ++end) {
    vertices.first[end] = vertices_[end].data() + patches_[patch].first_vertex;
    vertices.last_row[end] = vertices.first[end] + 3 * vertices.stride * vertices.last;
  }
  return vertices;
}

// False if a position of the row cannot be bounded.
bool SphereBuild::load_row(int patch, int row, const SphereVertices& vertices, Scratch& scratch) {
  const Patch& image = tree_.atlas->patches()[patch];
  const PatchPlan& plan = patches_[patch];
  const SphereKernels& kernels = sphere_kernels();
  const int texel = tree_.atlas->first_texel(patch) + (row < image.rows ? row : 0) * image.cols;
  const bool identity = tree_.atlas->is_identity();
  const std::int32_t* particle =
      identity ? nullptr : tree_.atlas->texel_to_particle().data() + texel;
  bool bounded = true;
  for (int end = 0; end < end_count_; ++end) {
    const double* positions =
        ends_[end].data()->data() + (identity ? 3 * std::ptrdiff_t{texel} : 0);
    float* out = vertices.at(end, row);
    float* image_row = plan.run_from.empty() ? out : scratch.image_row.data();
    std::array<float*, 3> component;
    for (int axis = 0; axis < 3; ++axis) component[axis] = image_row + axis * plan.stride;
    bounded =
        vertex_kernels().load(positions, particle, image.cols, limit_, component.data()) && bounded;
    for (int axis = 0; axis < 3; ++axis) {
      if (image.wrap_u) component[axis][image.cols] = component[axis][0];
      if (plan.run_from.empty()) continue;
      kernels.copy_runs(component[axis], plan.run_from.data(), plan.run_length.data(),
                        static_cast<int>(plan.run_from.size()), out + axis * plan.stride);
    }
  }
  return bounded;
}

// The first texel, of those that load_row refuses.
TexelAddress SphereBuild::first_unbounded() const {
  const auto is_bounded = [&](const Vec3& position) {
    // Not a maximum, which swallows what is not a number.
    return (position.cast<float>().array().abs() < limit_).all();
  };
  int texel = 0;
  const auto is_bounded_at_all_ends = [&] {
    const int particle = tree_.atlas->particle_of_texel(texel);
    return is_bounded(ends_[0][particle]) && (end_count_ == 1 || is_bounded(ends_[1][particle]));
  };
  while (is_bounded_at_all_ends()) ++texel;
  return tree_.atlas->texel_address(texel);
}

// One or two rows of blocks of the last level, from row v on.
void SphereBuild::bound_leaf_rows(int patch, int v, const SphereVertexRows& rows,
                                  Scratch& scratch) {
  const PatchPlan& plan = patches_[patch];
  const SphereKernels& kernels = sphere_kernels();
  const int level = tree_.numbers->levels(patch) - 1;
  const int blocks = 1 << plan.depth_u;
  const int count = rows.row_count - 1;
  std::array<SphereRow, 2> out;
  std::array<float*, 2> spheres{};
  for (int k = 0; k < count; ++k) {
    out[k] = block_row(patch, level, v + k, scratch);
    spheres[k] = spheres_of_row(patch, level, v + k);
  }
  kernels.bound_quads(rows, blocks, out.data(), spheres.data());
  for (int k = 0; k < count; ++k) {
    if (tree_.triangles != nullptr) bound_triangles(patch, v + k, rows, k);
    clear_empty(patch, level, v + k, out[k]);
  }
}

// Blocks without quads stand where an axis is split as far as it goes.
void SphereBuild::clear_empty(int patch, int level, int v, const SphereRow& row) {
  const PatchPlan& plan = patches_[patch];
  const BlockLevel& here = tree_.numbers->at(patch, level);
  const auto clear = [&](int u) {
    row.diameter[u] = -std::numeric_limits<float>::infinity();
    tree_.spheres[here.block(u, v)] = Sphere{};
  };
  if (here.log_v == plan.depth_v && boundary_row(patch, v) == boundary_row(patch, v + 1)) {
    for (int u = 0; u < 1 << here.log_u; ++u) clear(u);
  } else if (here.log_u == plan.depth_u) {
    for (const int u : plan.empty_columns) clear(u);
  }
}

void SphereBuild::bound_triangles(int patch, int v, const SphereVertexRows& rows, int first) {
  const PatchPlan& plan = patches_[patch];
  const int blocks = 1 << plan.depth_u;
  SphereVertexRows two = rows;
  two.row_count = 2;
  for (int end = 0; end < rows.ends; ++end) {
    two.row[end][0] = rows.row[end][first];
    two.row[end][1] = rows.row[end][first + 1];
  }
  Sphere* spheres = tree_.triangles + plan.first_triangle + 2 * std::size_t(blocks) * v;
  if (boundary_row(patch, v) == boundary_row(patch, v + 1)) {
    std::fill_n(spheres, 2 * blocks, Sphere{});
    return;
  }
  sphere_kernels().bound_triangles(two, blocks, &spheres->x);
  for (const int u : plan.empty_columns) spheres[2 * u] = spheres[2 * u + 1] = Sphere{};
}

SphereRow SphereBuild::block_row(int patch, int level, int v, Scratch& scratch) {
  PatchPlan& plan = patches_[patch];
  const std::size_t stride = padded(blocks_along(tree_.numbers->at(patch, level).log_u));
  float* first = level == plan.strip_level
                     ? plan.strip_tops.data() + planes * stride * v
                     : scratch.block_rows.data() + level_row_[level] + planes * stride * (v & 1);
  return row_at(first, stride);
}

float* SphereBuild::spheres_of_row(int patch, int level, int v) const {
  return &tree_.spheres[tree_.numbers->at(patch, level).block(0, v)].x;
}

// Makes every row above a finished one that it completes, up to level `top`.
void SphereBuild::climb(int patch, int level, int v, int top, const SphereVertices& vertices,
                        Scratch& scratch) {
  const SphereKernels& kernels = sphere_kernels();
  for (; level > top; --level) {
    const BlockLevel& here = tree_.numbers->at(patch, level);
    const BlockLevel& above = tree_.numbers->at(patch, level - 1);
    const bool split_u = above.log_u < here.log_u, split_v = above.log_v < here.log_v;
    if (split_v && v % 2 == 0) return;
    const SphereRow lower = block_row(patch, level, v, scratch);
    // Where the axis is not split the row has no partner but itself.
    const SphereRow upper = split_v ? block_row(patch, level, v - 1, scratch) : lower;
    if (split_v) v /= 2;
    const SphereRow out = block_row(patch, level - 1, v, scratch);
    const int blocks = 1 << above.log_u;
    if (keeps_vertices_) {
      kernels.merge_boxes(upper, lower, split_u, blocks, out);
      reach_vertices(patch, level - 1, v, vertices, out, scratch);
    } else {
      kernels.merge(upper, lower, split_u, blocks, out, spheres_of_row(patch, level - 1, v));
    }
    clear_empty(patch, level - 1, v, out);
  }
}

// Exact radii of a row of blocks, from their vertices or, where these are many, from the spheres
// below.
void SphereBuild::reach_vertices(int patch, int level, int v, const SphereVertices& vertices,
                                 const SphereRow& row, Scratch& scratch) {
  const PatchPlan& plan = patches_[patch];
  const SphereKernels& kernels = sphere_kernels();
  const BlockLevel& here = tree_.numbers->at(patch, level);
  const int log_u = plan.depth_u - here.log_u, log_v = plan.depth_v - here.log_v;
  const int blocks = 1 << here.log_u;
  float* squared = scratch.squared.data();
  if (log_u <= visited_log && log_v <= visited_log) {
    const int columns = 1 << plan.depth_u;
    std::array<float*, 3> centre;
    for (int axis = 0; axis < 3; ++axis) centre[axis] = &scratch.centres[axis * vertex_stride_];
    kernels.spread_centres(row, log_u, columns, centre.data());
    std::fill_n(squared, columns, 0.0F);
    for (int end = 0; end < end_count_; ++end) {
      for (int i = boundary_row(patch, v << log_v); i <= boundary_row(patch, (v + 1) << log_v);
           ++i) {
        kernels.reach(vertices.row(end, i), centre.data(), columns, squared);
      }
    }
    kernels.fold(log_u, blocks, squared);
  } else {
    for (int u = 0; u < blocks; ++u) {
      std::array<float, 3> centre;
      for (int axis = 0; axis < 3; ++axis) {
        centre[axis] = 0.5F * (row.low[axis][u] + row.high[axis][u]);
      }
      squared[u] = squared_reach(tree_, vertices, patch, level, u, v, centre.data(), 0);
    }
  }
  kernels.cover(squared, blocks, row, spheres_of_row(patch, level, v));
}

void SphereBuild::join_strips(int patch) {
  PatchPlan& plan = patches_[patch];
  const SphereVertices vertices = kept_vertices(patch);
  for (int v = 0; v < 1 << plan.strip_level; ++v) {
    climb(patch, plan.strip_level, v, 0, vertices, scratch_[0]);
  }
  const SphereRow top = block_row(patch, 0, 0, scratch_[0]);
  for (int axis = 0; axis < 3; ++axis) {
    plan.box.low[axis] = top.low[axis][0];
    plan.box.high[axis] = top.high[axis][0];
  }
}

// The carried-up radii are loosest at the top (by up to 44 % on a torus), where there are so few
// blocks that each can be bounded from its descendants three levels down.
void SphereBuild::tighten_top_levels(int patch) {
  constexpr int down = 3;
  constexpr int top_levels = 4;
  const SphereKernels& kernels = sphere_kernels();
  for (int level = std::min(top_levels, tree_.numbers->levels(patch) - down) - 1; level >= 0;
       --level) {
    const BlockLevel& here = tree_.numbers->at(patch, level);
    const BlockLevel& below = tree_.numbers->at(patch, level + down);
    const int shift_u = below.log_u - here.log_u;
    const int shift_v = below.log_v - here.log_v;
    for (int v = 0; v < 1 << here.log_v; ++v) {
      for (int u = 0; u < 1 << here.log_u; ++u) {
        Sphere& parent = tree_.spheres[here.block(u, v)];
        const Sphere& first = tree_.spheres[below.block(u << shift_u, v << shift_v)];
        const float reach = kernels.reach_of_spheres(&first.x, std::size_t{4} << below.log_u,
                                                     1 << shift_v, 1 << shift_u, &parent.x);
        parent.radius = std::min(parent.radius, reach * round_up + radius_floor);
      }
    }
  }
}

void SphereBuild::bound_groups() {
  const BlockLevels& numbers = *tree_.numbers;
  for (int level = numbers.group_levels() - 1; level >= 0; --level) {
    for (int index = 0; index < 1 << level; ++index) {
      const auto [begin, end] = numbers.patches_of_group(level, index);
      PatchBox box = patches_[begin].box;
      for (int patch = begin + 1; patch < end; ++patch) {
        for (int axis = 0; axis < 3; ++axis) {
          box.low[axis] = std::min(box.low[axis], patches_[patch].box.low[axis]);
          box.high[axis] = std::max(box.high[axis], patches_[patch].box.high[axis]);
        }
      }
      std::array<float, 3> centre;
      for (int axis = 0; axis < 3; ++axis) centre[axis] = 0.5F * (box.low[axis] + box.high[axis]);
      Sphere bound{centre[0], centre[1], centre[2], 0};
      const float magnitude = std::fabs(bound.x) + std::fabs(bound.y) + std::fabs(bound.z);
      if (keeps_vertices_) {
        float squared = 0;
        for (int patch = begin; patch < end; ++patch) {
          squared =
              squared_reach(tree_, kept_vertices(patch), patch, 0, 0, 0, centre.data(), squared);
        }
        bound.radius = std::sqrt(squared) * round_up + (magnitude * centre_rounding + radius_floor);
      } else {
        float reach = 0;
        for (int patch = begin; patch < end; ++patch) {
          reach = std::max(reach, reach_of(bound, tree_.spheres[numbers.at(patch, 0).first]));
        }
        const float diagonal =
            length(box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]);
        bound.radius =
            std::min(reach * round_up + radius_floor,
                     0.5F * diagonal * round_up + (magnitude * box_rounding + radius_floor));
      }
      tree_.groups[(std::size_t{1} << level) - 1 + index] = bound;
    }
  }
}

}  // namespace weft::bsi
