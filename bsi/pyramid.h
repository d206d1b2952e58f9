// The bounding sphere image pyramid: a hierarchy of spheres over a geometry image, rebuilt from the
// deformed image in one O(n) pass.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bsi/block_levels.h"
#include "bsi/block_row.h"
#include "bsi/geometry_image.h"

namespace weft::bsi {

// Texel of a level: centre and radius in float32. A negative radius marks a block without quads.
struct Sphere {
  float x = 0, y = 0, z = 0;
  float radius = -1;
};

// A distance that no point of one sphere to a point of the other falls short of, whatever the
// rounding; 0 where they meet, infinity when one of them is empty. Metres.
double bounding_sphere_gap(const Sphere& first, const Sphere& second);

enum class RadiusPolicy {
  // Largest distance from the centre to any contained vertex, rounded up. (Blocks of one quad round
  // their vertices to float32 first, and are larger by up to 2^-22 of the largest coordinate.)
  exact,
  // Carried up from the children: max |c - c_i| + r_i, never more than the half diagonal.
  fast,
};

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

// A sphere for each block of BlockLevels and each group of patches above the patch tops.
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
  explicit Pyramid(const Atlas& atlas, RadiusPolicy policy = RadiusPolicy::fast);

  // Rebuilds every level from the positions (metres) of the atlas' particles. O(quads). Returns the
  // first texel whose position is not finite (the pyramid is then not usable until the next
  // rebuild). Allocates nothing.
  [[nodiscard]] std::optional<TexelAddress> rebuild(std::span<const Vec3> positions);
  // Bounds every vertex at both ends of its path, and so all along a straight one.
  [[nodiscard]] std::optional<TexelAddress> rebuild_swept(std::span<const Vec3> start,
                                                          std::span<const Vec3> end);
  // True after a rebuild that found every position finite.
  bool is_built() const { return built_; }

  const Atlas& atlas() const { return atlas_; }
  int patch_count() const { return numbers_.patch_count(); }
  int levels(int patch) const { return numbers_.levels(patch); }
  int blocks_u(int patch, int level) const { return 1 << numbers_.at(patch, level).log_u; }
  int blocks_v(int patch, int level) const { return 1 << numbers_.at(patch, level).log_v; }
  QuadRange quads(int patch, int level, int u, int v) const {
    return numbers_.quads(patch, level, u, v);
  }
  const Sphere& sphere(int patch, int level, int u, int v) const {
    return spheres_[numbers_.at(patch, level).block(u, v)];
  }
  // All spheres of a level, row by row (v), blocks_u(patch, level) a row.
  std::span<const Sphere> level_spheres(int patch, int level) const;
  // Levels above the patch tops: 0 for a single patch, else ceil(log2(patches)).
  int group_levels() const { return numbers_.group_levels(); }
  // The 2^level spheres of a level above the patch tops.
  std::span<const Sphere> group_spheres(int level) const;
  // Bounds the whole body.
  const Sphere& top() const { return sphere(root()); }

  // The tree, for traversals. Its leaves are blocks of one quad.
  Block root() const { return {group_levels() > 0 ? Block::group : 0, 0, 0, 0}; }
  const Sphere& sphere(const Block& block) const {
    if (block.patch != Block::group) {
      return sphere(block.patch, block.level, block.u, block.v);
    }
    return group_spheres(block.level)[block.u];
  }
  bool is_leaf(const Block& block) const {
    return block.patch != Block::group && block.level + 1 == levels(block.patch);
  }
  // The quad that a leaf bounds, in the atlas' numbers.
  int quad_of_leaf(const Block& leaf) const;
  // The 1 to 4 children that are not empty, u before v; returns their number. Not for leaves.
  int children(const Block& block, std::array<Block, 4>& child) const;

 private:
  struct Box {
    std::array<float, 3> low{}, high{};
  };

  void reserve_rows(int patch);
  std::optional<TexelAddress> rebuild_all();
  std::optional<TexelAddress> rebuild_patch(int patch);
  template <int ends>
  bool load_row(int patch, int row, VertexRow& vertices) const;
  TexelAddress first_unbounded(int patch, int row) const;
  void finish_row(int patch, int level, int v);
  void tighten_top_levels(int patch);
  void rebuild_groups();
  void refine_to_exact();
  float exact_radius(const Block& block);
  double squared_reach(const Block& block, const Vec3& centre);
  double squared_reach_of_vertices(int patch, const QuadRange& range, int row_step, int col_step,
                                   const Vec3& centre) const;
  QuadRange quads(const Block& block) const {
    return quads(block.patch, block.level, block.u, block.v);
  }

  Atlas atlas_;
  RadiusPolicy policy_ = RadiusPolicy::fast;
  BlockLevels numbers_;
  std::vector<Sphere> spheres_;  // in the order of numbers_, then those of the groups, from the top
  bool built_ = false;

  // Of the rebuild in progress.
  std::array<std::span<const Vec3>, 2> ends_;
  int end_count_ = 1;
  std::array<VertexRow, 2> vertex_rows_;
  BlockRow quad_row_;
  std::vector<std::array<BlockRow, 2>> block_rows_;  // by level: an even and an odd row
  std::vector<Box> patch_boxes_;
  std::vector<Block> pending_;
};

}  // namespace weft::bsi
