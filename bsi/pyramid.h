// The bounding sphere image of a body: a pyramid of boxes and spheres over its geometry image. It
// is rebuilt from the deformed image in one pass, and the traversals descend it.
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

// A box of vertices rounded to float32, m.
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

struct PyramidParts {
  // Bounds of the steps between vertices. With them, self traversals skip whole blocks that cannot
  // touch themselves (docs/theory.md, "The tangent certificate"). They take more than half of the
  // time of a rebuild.
  bool tangents = true;
  // Spheres, for pictures and for traversals whose bound is not `box`.
  bool spheres = false;
};

// Level l of a patch splits its quads into up to 2^l x 2^l nested blocks. Each axis stops at blocks
// of one or two quads; boundaries are block_boundary(k, quads, log). The last level holds the leaf
// blocks. No block is empty. Above the patch tops of a body of several patches there are groups:
// level k has 2^k of them, whose numbers of patches differ by at most one. A group is split along
// the longest side of the box around its patches' centres, as they lay at the first rebuild.
//
// The pyramid holds a box for every block, the vertices in float32, and the parts that PyramidParts
// names. Boxes lie exactly inside their parents', because minima and maxima round nothing. They
// bound the vertices rounded to float32; the traversals widen them by the possible rounding.
//
// A sphere is centred in its block's box and contains the boxes of all leaf blocks below. Spheres
// therefore never separate leaves whose boxes overlap. Its radius is the lesser of half the box's
// diagonal and the reach of the children's spheres; the four top levels use the spheres of the
// sixth. Every float64 vertex lies inside.
//
// Pyramids can be moved, not copied. Const members are safe to call from several threads at once.
class Pyramid {
 public:
  // Coordinates of at least this size (m) are treated as not finite.
  static constexpr float coordinate_limit = 1e18F;
  // Largest number of quads along an axis of a patch.
  static constexpr int quad_limit = 1 << 17;

  // Throws std::invalid_argument, naming the patch, if an axis has more than quad_limit quads.
  explicit Pyramid(const Atlas& atlas, const PyramidParts& parts = {});
  Pyramid(Pyramid&&) = default;
  Pyramid& operator=(Pyramid&&) = default;

  // Rebuilds everything from the positions (m) of the atlas' particles on `threads` threads (0: as
  // many as OpenMP uses). Any number of threads gives the same bits. O(quads); allocates nothing.
  // Returns the first texel whose position is not finite, if any; the pyramid is then unusable
  // until the next rebuild.
  [[nodiscard]] std::optional<TexelAddress> rebuild(std::span<const Vec3> positions,
                                                    int threads = 0);
  // Bounds every vertex at both ends of its path, and hence on the straight path between them. The
  // first call allocates the second image.
  [[nodiscard]] std::optional<TexelAddress> rebuild_swept(std::span<const Vec3> start,
                                                          std::span<const Vec3> end,
                                                          int threads = 0);
  // True after a rebuild that found every position finite.
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
  // Returns the patches of the u-th group of a level above the patch tops.
  std::span<const std::int32_t> patches_of_group(int level, int u) const {
    const auto [begin, end] = group_range(patch_count(), level, u);
    return std::span(patch_order_).subspan(begin, end - begin);
  }
  const Box& group_box(int level, int u) const {
    return group_boxes_[(std::size_t{1} << level) - 1 + u];
  }
  // Returns the box of the whole body.
  Box top() const { return group_levels_ > 0 ? group_box(0, 0) : box(0, 0, 0, 0); }
  // The largest |coordinate| of the float32 vertices, m.
  float magnitude() const { return tree_.magnitude; }
  std::size_t bytes() const;
  // The pyramid in plain pointers, for the kernels of the traversals.
  const BoxTree& tree() const { return tree_; }

 private:
  // A run of rows of leaf blocks of a patch, bounded by one thread, with the rows being built.
  struct Strip {
    int patch = 0;
    int index = 0;
    std::vector<float> rows;       // two per level, and those of the columns of vertices
    std::vector<std::size_t> row;  // start of the rows of each level
    std::size_t columns = 0;
    // The row of vertices shared with the next strip, at both ends of its path.
    std::array<std::vector<float>, 2> boundary;
    bool finite = true;
  };
  // The starts of a level in the arrays.
  struct LevelPlace {
    std::size_t groups = 0;
    std::size_t tangents = 0;
  };
  // The place of a block among the children of its parent.
  struct ChildPlace {
    std::size_t parent = 0;  // among the groups of its level
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
  std::vector<LevelPlace> places_;         // by level, like levels_
  std::vector<std::size_t> first_vertex_;  // by patch, into vertices_
  std::vector<int> strip_log_;             // by patch: log2 of its number of strips
  std::vector<std::int32_t> boundaries_;   // of the columns of leaf blocks, patch by patch
  std::vector<std::size_t> first_boundary_;
  int group_levels_ = 0;
  std::vector<std::int32_t> patch_order_;  // groups are runs of these
  bool is_ordered_ = false;
  std::vector<BoxGroup> groups_;
  std::vector<TangentBounds> tangents_;
  std::vector<SphereGroup> spheres_;  // like groups_, or empty
  std::array<std::vector<float>, 2> vertices_;
  std::vector<Box> group_boxes_;
  std::vector<Strip> strips_;
  BoxTree tree_{};
  bool built_ = false;
  std::array<std::span<const Vec3>, 2> ends_;  // of the rebuild in progress
};

}  // namespace weft::bsi
