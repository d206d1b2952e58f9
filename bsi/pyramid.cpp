#include "bsi/pyramid.h"

#include <omp.h>

#include <algorithm>
#include <cassert>
#include <limits>

#include "bsi/level_build.h"

namespace weft::bsi {

namespace {

int team_of(int threads) { return threads > 0 ? threads : omp_get_max_threads(); }

}  // namespace

double bounding_sphere_gap(const Sphere& first, const Sphere& second) {
  if (first.radius < 0 || second.radius < 0) return std::numeric_limits<double>::infinity();
  const auto centre_of = [](const Sphere& sphere) { return Vec3(sphere.x, sphere.y, sphere.z); };
  // The distance is good to 4 units of 2^-53, the sum of radii to one.
  const double distance = (centre_of(first) - centre_of(second)).norm() * (1 - 0x1p-49);
  const double radii = static_cast<double>(first.radius) + static_cast<double>(second.radius);
  return std::max(0.0, distance - radii);
}

Pyramid::Pyramid(const Atlas& atlas, RadiusPolicy policy, Leaf leaf)
    : atlas_(atlas), policy_(policy), numbers_(atlas), build_(atlas, numbers_, policy) {
  std::size_t count = numbers_.block_count() + group_count();
  for (int patch = 0; leaf == Leaf::triangle && patch < patch_count(); ++patch) {
    const BlockLevel& quads = numbers_.at(patch, numbers_.levels(patch) - 1);
    triangles_.push_back({count, quads.log_u + 1, quads.log_v});
    count += triangles_.back().count();
  }
  spheres_.resize(padding + count);
}

QuadRange Pyramid::quads(int patch, int level, int u, int v) const {
  if (level == numbers_.levels(patch)) return numbers_.quads(patch, level - 1, u / 2, v);
  return numbers_.quads(patch, level, u, v);
}

std::span<const Sphere> Pyramid::level_spheres(int patch, int level) const {
  const BlockLevel& here = place(patch, level);
  return {first_sphere() + here.first, here.count()};
}

std::span<const Sphere> Pyramid::group_spheres(int level) const {
  const std::size_t count = std::size_t{1} << level;
  return {first_sphere() + numbers_.block_count() + count - 1, count};
}

int Pyramid::quad_of_leaf(const Block& leaf) const {
  assert(is_leaf(leaf));
  const QuadRange range = quads(leaf.patch, leaf.level, leaf.u, leaf.v);
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
  const BlockLevel& here = place(block.patch, block.level);
  const BlockLevel& below = place(block.patch, next);
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

std::uint64_t Pyramid::flat_index(const Block& block) const {
  assert(block.patch != Block::group && block.level < numbers_.levels(block.patch));
  const BlockLevel& here = place(block.patch, block.level);
  return bsi::flat_index({block.level,
                          static_cast<std::uint32_t>(block.u) << (block.level - here.log_u),
                          static_cast<std::uint32_t>(block.v) << (block.level - here.log_v)});
}

Block Pyramid::block_of_flat_index(int patch, std::uint64_t index) const {
  const QuadtreePlace node = quadtree_place(index);
  assert(node.level < numbers_.levels(patch));
  const BlockLevel& here = place(patch, node.level);
  return {patch, node.level, static_cast<int>(node.u >> (node.level - here.log_u)),
          static_cast<int>(node.v >> (node.level - here.log_v))};
}

std::size_t Pyramid::bytes() const { return spheres_.size() * sizeof(Sphere) + build_.bytes(); }

std::optional<TexelAddress> Pyramid::rebuild(std::span<const Vec3> positions, int threads) {
  return rebuild_from(std::array{positions}, threads);
}

std::optional<TexelAddress> Pyramid::rebuild_swept(std::span<const Vec3> start,
                                                   std::span<const Vec3> end, int threads) {
  return rebuild_from(std::array{start, end}, threads);
}

std::optional<TexelAddress> Pyramid::rebuild_from(std::span<const std::span<const Vec3>> ends,
                                                  int threads) {
  for (const auto& positions : ends) {
    assert(static_cast<int>(positions.size()) == atlas_.particle_count());
    static_cast<void>(positions);
  }
  Sphere* spheres = spheres_.data() + padding;
  Sphere* groups = spheres + numbers_.block_count();
  const SphereTree tree{&atlas_, &numbers_, spheres, groups,
                        has_triangles() ? groups + group_count() : nullptr};
  const int team = team_of(threads);
  const auto unbounded = build_.run(tree, ends, coordinate_limit, team);
  if (!unbounded && policy_ == RadiusPolicy::tight) tighten(tree, ends, team);
  built_ = !unbounded;
  return unbounded;
}

void rebuild(std::span<PyramidRebuild> bodies, int threads) {
  const int team = team_of(threads);
  const auto run = [team](PyramidRebuild& body) {
    body.unbounded = body.end.empty() ? body.pyramid->rebuild(body.start, team)
                                      : body.pyramid->rebuild_swept(body.start, body.end, team);
  };
  for (PyramidRebuild& body : bodies) {
    if (body.pyramid->is_parallel()) run(body);
  }
#pragma omp parallel for schedule(dynamic, 1) num_threads(team) if (bodies.size() > 1)
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies[i].pyramid->is_parallel()) run(bodies[i]);
  }
}

}  // namespace weft::bsi
