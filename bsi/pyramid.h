// The bounding sphere image of a body: a pyramid of boxes and spheres over its geometry image. It
// is rebuilt from each deformed image, and the traversals descend it.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "bsi/detail/block_levels.h"
#include "bsi/detail/bound_rows.h"
#include "bsi/detail/box_layout.h"
#include "bsi/geometry_image.h"
#include "bsi/sphere.h"

namespace weft::bsi {

// An axis-aligned bounding box of vertices that are rounded to float32, m.
struct Box {
  std::array<float, 3> low{};
  std::array<float, 3> high{};
  bool operator==(const Box&) const = default;
};

// Block (u, v) of a level of a patch (see Pyramid).
struct PatchBlock {
  int patch = 0, level = 0, u = 0, v = 0;
  bool operator==(const PatchBlock&) const = default;
};

// Optional parts of a pyramid.
struct PyramidParts {
  // Bounds of the steps, which are the differences between adjacent vertices. With them, self
  // traversals skip whole blocks that cannot touch themselves (docs/theory.md, "The tangent
  // certificate"). Computing them takes a large part of the time of a rebuild.
  bool tangents = true;
  // Bounding spheres of the blocks. Traversals whose bound is not `box` need them, and so does
  // detail_at_levels().
  bool spheres = false;
};

// A pyramid of bounds over the patches of a body. Level l of a patch splits its quads into up to
// 2^l x 2^l nested blocks. Along each axis the splitting stops at blocks of one or two quads. Block
// boundaries are block_boundary(k, quads, log). The last level holds the leaf blocks. No block is
// empty.
//
// A body of several patches has groups above its patches. Group level k has 2^k groups, whose
// numbers of patches differ by at most one. A group is split along the longest side of the box
// around its patches' centres. The positions at the first successful rebuild determine the groups.
//
// The pyramid holds a box for every block, the vertices in float32, and the parts that PyramidParts
// selects. A box lies inside its parent's box without any allowance, because minima and maxima
// round nothing. Boxes bound the vertices rounded to float32; the traversals widen them by the
// possible rounding.
//
// The sphere of a block is centred in the block's box and contains the boxes of all leaf blocks
// below. Spheres therefore never separate leaves whose boxes overlap. The radius is half the
// diagonal of the box or, if smaller, the radius that contains the children's spheres. Radii on
// levels 0 to 3 are further reduced to those that contain the spheres of level 5, or of the last
// level. Every float64 vertex of the block lies inside.
//
// Pyramids can be moved, not copied. Const members are safe to call from several threads at once.
class Pyramid {
 public:
  // Coordinates that are at least this large (m) after rounding to float32 count as not finite.
  static constexpr float coordinate_limit = 1e18F;
  // Largest number of quads along an axis of a patch.
  static constexpr int quad_limit = 1 << 17;

  // Throws std::invalid_argument if the atlas has no patches or, naming the patch, if an axis has
  // no quads, as in Atlas::of_points(), or more than quad_limit.
  explicit Pyramid(const Atlas& atlas, const PyramidParts& parts = {});
  Pyramid(Pyramid&&) = default;
  Pyramid& operator=(Pyramid&&) = default;

  // Rebuilds all bounds from the positions (m) of the atlas' particles on `threads` threads (0: the
  // default of OpenMP). The result has the same bits for any number of threads. O(quads); allocates
  // nothing after the first call. Returns the first texel whose position is not finite (see
  // coordinate_limit), if any. The pyramid is then unusable until a rebuild succeeds.
  [[nodiscard]] std::optional<TexelAddress> rebuild(std::span<const Vec3> positions,
                                                    int threads = 0);
  // Rebuilds all bounds for straight paths start -> end (m). Every vertex is bounded at both ends,
  // and hence all along its path. Otherwise like rebuild(). The first call also allocates a second
  // image of vertices.
  [[nodiscard]] std::optional<TexelAddress> rebuild_swept(std::span<const Vec3> start,
                                                          std::span<const Vec3> end,
                                                          int threads = 0);
  // Returns true if the last rebuild found every position finite.
  bool is_built() const { return built_; }

  const Atlas& atlas() const { return atlas_; }
  const PyramidParts& parts() const { return parts_; }
  int patch_count() const { return static_cast<int>(patches_.size()); }
  int levels(int patch) const { return patches_[patch].level_count; }
  int blocks_u(int patch, int level) const { return 1 << level_of(patch, level).log_u; }
  int blocks_v(int patch, int level) const { return 1 << level_of(patch, level).log_v; }
  QuadRange quads(int patch, int level, int u, int v) const;
  Box box(int patch, int level, int u, int v) const;
  // Precondition: parts().spheres.
  Sphere sphere(int patch, int level, int u, int v) const;
  Sphere sphere(const PatchBlock& block) const {
    return sphere(block.patch, block.level, block.u, block.v);
  }
  int group_levels() const { return group_levels_; }
  // Returns the patches of group `u` of a level of groups.
  std::span<const std::int32_t> patches_of_group(int level, int u) const {
    const auto [begin, end] = group_range(patch_count(), level, u);
    return std::span(patch_order_).subspan(begin, end - begin);
  }
  const Box& group_box(int level, int u) const {
    return group_boxes_[(std::size_t{1} << level) - 1 + u];
  }
  // Returns the box of the whole body.
  Box top() const { return group_levels_ > 0 ? group_box(0, 0) : box(0, 0, 0, 0); }
  // Returns the largest |coordinate| (m) of the vertices rounded to float32.
  float magnitude() const { return tree_.magnitude; }
  std::size_t bytes() const;
  // Returns the plain pointers through which kernels read the pyramid.
  const BoxTree& tree() const { return tree_; }

 private:
  // A strip of a patch: consecutive rows of leaf blocks that one thread bounds, with scratch memory
  // for rows of bounds.
  struct Strip {
    int patch = 0;
    int index = 0;
    std::vector<float> rows;       // two rows per level, then bounds of columns of vertices
    std::vector<std::size_t> row;  // index in `rows` of each level's first row
    std::size_t columns = 0;       // index in `rows` of the bounds of columns
    // The row of vertices that this strip shares with the next strip, at both ends of the paths.
    std::array<std::vector<float>, 2> boundary;
    bool finite = true;
  };
  // Indices of the data of a level's first block: `groups` in groups_ and spheres_, `tangents` in
  // tangents_.
  struct LevelPlace {
    std::size_t groups = 0;
    std::size_t tangents = 0;
  };
  // The parent of a block, and the index of the block among the parent's children.
  struct ChildPlace {
    std::size_t parent = 0;  // index of the parent on its level
    int child = 0;
  };

  const BoxLevel& level_of(int patch, int level) const {
    return levels_[patches_[patch].first_level + level];
  }
  // Precondition: level > 0.
  ChildPlace child_place(int patch, int level, int u, int v) const;
  void add_patch(int patch);
  void add_strips(int patch);
  void point_views();
  std::optional<TexelAddress> rebuild_all(int ends, int threads);
  void rebuild_strip(Strip& strip);
  bool load_row(Strip& strip, int row, int end);
  VertexRows vertex_rows(const Strip& strip, int first_row, int last_row, int end) const;
  void bound_leaf_row(Strip& strip, int v);
  void bound_step_row(Strip& strip, int v, BoundRow out);
  void finish_row(Strip& strip, int v);
  void join_strips(std::span<Strip> strips);
  void merge_into_parent(int patch, int level, BoundRow upper, BoundRow lower, int v, BoundRow out);
  void store_tangents(int patch, int level, int v, BoundRow row);
  BoundRow row(Strip& strip, int level, int v) const;
  TexelAddress first_unbounded() const;
  void order_patches();
  void rebuild_groups();
  void rebuild_spheres(int patch, int threads);
  void tighten_spheres(int patch);
  float& radius_of(int patch, int level, int u, int v);

  Atlas atlas_;
  PyramidParts parts_;
  std::vector<BoxPatch> patches_;
  std::vector<BoxLevel> levels_;
  std::vector<LevelPlace> places_;           // indexed like levels_
  std::vector<std::size_t> first_vertex_;    // index in vertices_ of each patch's first vertex
  std::vector<int> strip_log_;               // log2 of each patch's number of strips
  std::vector<std::int32_t> boundaries_;     // boundaries of the columns of leaf blocks, in quads
  std::vector<std::size_t> first_boundary_;  // index in boundaries_ of each patch's first boundary
  int group_levels_ = 0;
  std::vector<std::int32_t> patch_order_;  // patches in the order of their groups
  bool is_ordered_ = false;
  std::vector<BoxGroup> groups_;
  std::vector<TangentBounds> tangents_;
  std::vector<SphereGroup> spheres_;            // indexed like groups_; empty without spheres
  std::array<std::vector<float>, 2> vertices_;  // vertices at the start and the end of the paths
  std::vector<Box> group_boxes_;
  std::vector<Strip> strips_;
  BoxTree tree_{};
  bool built_ = false;
  std::array<std::span<const Vec3>, 2> ends_;  // particle positions that a rebuild reads
};

}  // namespace weft::bsi
