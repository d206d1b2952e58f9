// The bounding sphere image pyramid: a hierarchy of spheres over a geometry image, rebuilt from the
// deformed image in one O(n) pass.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bsi/aligned_vector.h"
#include "bsi/block_levels.h"
#include "bsi/geometry_image.h"
#include "bsi/leaf_pair.h"
#include "bsi/quadtree_index.h"
#include "bsi/sphere.h"
#include "bsi/sphere_build.h"

namespace weft::bsi {

// The number of a node of the hierarchy: block (u, v) of a level of a patch, or, with patch ==
// group, the u-th group of patches at a level above the patch tops (v = 0).
struct Block {
  static constexpr int group = -1;
  int patch = 0;
  int level = 0;
  int u = 0;
  int v = 0;
  bool operator==(const Block&) const = default;
};

// A sphere for each block of BlockLevels and each group of patches above the patch tops. Where the
// leaves are triangles, every patch has one more level, which splits each quad's block in two
// along u.
//
// Conservative: every float64 vertex lies inside the float32 spheres of all the blocks that contain
// it, whatever the rounding. Spheres of children may stick out of their parent's.
//
// All const members may be called from many threads at once.
class Pyramid {
 public:
  // Coordinates of this size (metres) and beyond cannot be bounded in float32, whose squares would
  // overflow; a rebuild treats them like those that are not finite.
  static constexpr float coordinate_limit = 1e18F;

  Pyramid() = default;
  explicit Pyramid(const Atlas& atlas, RadiusPolicy policy = RadiusPolicy::fast,
                   Leaf leaf = Leaf::quad);

  // Rebuilds every level from the positions (metres) of the atlas' particles, on `threads` threads
  // (0: those of OpenMP; one within a parallel region), with the same bits for any number of them
  // and any instruction set. O(quads). Returns the first texel whose position is not finite (the
  // pyramid is then not usable until the next rebuild). Allocates on the first call alone, on the
  // first swept one and on those of more threads than before.
  [[nodiscard]] std::optional<TexelAddress> rebuild(std::span<const Vec3> positions,
                                                    int threads = 0);
  // Bounds every vertex at both ends of its path, and so all along a straight one.
  [[nodiscard]] std::optional<TexelAddress> rebuild_swept(std::span<const Vec3> start,
                                                          std::span<const Vec3> end,
                                                          int threads = 0);
  // True after a rebuild that found every position finite.
  bool is_built() const { return built_; }

  const Atlas& atlas() const { return atlas_; }
  int patch_count() const { return numbers_.patch_count(); }
  int levels(int patch) const { return numbers_.levels(patch) + (has_triangles() ? 1 : 0); }
  int blocks_u(int patch, int level) const { return 1 << place(patch, level).log_u; }
  int blocks_v(int patch, int level) const { return 1 << place(patch, level).log_v; }
  // Of a triangle: its quad.
  QuadRange quads(int patch, int level, int u, int v) const;
  const Sphere& sphere(int patch, int level, int u, int v) const {
    return first_sphere()[place(patch, level).block(u, v)];
  }
  // All spheres of a level, row by row (v), blocks_u(patch, level) a row.
  std::span<const Sphere> level_spheres(int patch, int level) const;
  // Levels above the patch tops: 0 for a single patch, else ceil(log2(patches)).
  int group_levels() const { return numbers_.group_levels(); }
  // The 2^level spheres of a level above the patch tops.
  std::span<const Sphere> group_spheres(int level) const;
  // Bounds the whole body.
  const Sphere& top() const { return sphere(root()); }

  // The tree, for traversals.
  Block root() const { return {group_levels() > 0 ? Block::group : 0, 0, 0, 0}; }
  const Sphere& sphere(const Block& block) const {
    if (block.patch != Block::group) {
      return sphere(block.patch, block.level, block.u, block.v);
    }
    return group_spheres(block.level)[block.u];
  }
  // Blocks of one quad or, on request, of one triangle.
  bool is_leaf(const Block& block) const {
    return block.patch != Block::group && block.level + 1 == levels(block.patch);
  }
  // The quad that a leaf bounds, or whose triangle it does, in the atlas' numbers.
  int quad_of_leaf(const Block& leaf) const;
  // Leaves of triangles only; in the numbers of Mesh.
  int triangle_of_leaf(const Block& leaf) const { return 2 * quad_of_leaf(leaf) + (leaf.u & 1); }
  // The 1 to 4 children that are not empty, u before v; returns their number. Not for leaves.
  int children(const Block& block, std::array<Block, 4>& child) const;

  // The number of a block of quads in the quadtree of its patch (quadtree_index.h): child i of n is
  // 4 n + i. Where an axis is split no more there is one child instead of two, the first. O(level).
  std::uint64_t flat_index(const Block& block) const;
  // Precondition: the index of a block.
  Block block_of_flat_index(int patch, std::uint64_t index) const;

  // Memory held.
  std::size_t bytes() const;
  // True for a body so large that several threads share its rebuild.
  bool is_parallel() const { return build_.is_parallel(); }

 private:
  // In front of the spheres, which puts the levels of a square image on cache lines: level l has
  // (4^l - 1) / 3 spheres before it, one more than a multiple of four.
  static constexpr std::size_t padding = 3;

  bool has_triangles() const { return !triangles_.empty(); }
  // Counted from first_sphere().
  const BlockLevel& place(int patch, int level) const {
    return level < numbers_.levels(patch) ? numbers_.at(patch, level) : triangles_[patch];
  }
  const Sphere* first_sphere() const { return spheres_.data() + padding; }
  std::size_t group_count() const { return (std::size_t{1} << group_levels()) - 1; }
  std::optional<TexelAddress> rebuild_from(std::span<const std::span<const Vec3>> ends,
                                           int threads);

  Atlas atlas_;
  RadiusPolicy policy_ = RadiusPolicy::fast;
  BlockLevels numbers_;
  std::vector<BlockLevel> triangles_;  // by patch
  // Of the blocks, then of the groups, then of the triangles.
  AlignedVector<Sphere> spheres_;
  SphereBuild build_;
  bool built_ = false;
};

// One body of a scene: swept where `end` is not empty.
struct PyramidRebuild {
  Pyramid* pyramid = nullptr;
  std::span<const Vec3> start;
  std::span<const Vec3> end;
  std::optional<TexelAddress> unbounded;  // the result, as of Pyramid::rebuild
};

// Rebuilds many bodies on `threads` threads (0: those of OpenMP): large ones one after the other on
// all of them, the others one a thread. The pyramids must be different ones.
void rebuild(std::span<PyramidRebuild> bodies, int threads = 0);

}  // namespace weft::bsi
