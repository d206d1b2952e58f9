// The bounding sphere image of a body: a pyramid of boxes and spheres over its geometry image,
// rebuilt from the deformed image in one pass, which the traversals descend.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "bsi/detail/block_levels.h"
#include "bsi/detail/box_layout.h"
#include "bsi/geometry_image.h"
#include "bsi/kernels/box_build_kernels.h"
#include "bsi/sphere.h"

namespace weft::bsi {

// Bounds of vertices rounded to float32, metres.
struct Box {
  std::array<float, 3> low{};
  std::array<float, 3> high{};
  bool operator==(const Box&) const = default;
};

// Block (u, v) of a level of a patch: see Pyramid.
struct PatchBlock {
  int patch = 0, level = 0, u = 0, v = 0;
  bool operator==(const PatchBlock&) const = default;
};

struct PyramidParts {
  // Bounds of the steps between vertices, by which whole blocks are excused from looking for
  // contact with themselves (docs/theory.md, "The tangent certificate"); they take more than half
  // of a rebuild.
  bool tangents = true;
  // Traversals whose bound is not `box` need spheres, and so do pictures.
  bool spheres = false;
};

// Level l of a patch splits its quads into up to 2^l x 2^l nested blocks, each axis stopping at
// blocks of one or two quads; block boundaries are block_boundary(k, quads, log). The last level
// holds the leaf blocks. No block is empty. Above the patch tops of a body of several patches stand
// groups: level k has 2^k of them, never empty, whose numbers of patches differ by one at most.
// Groups go by place: each is split along the longest side of the box around its patches' centres,
// as these lay at the first rebuild.
//
// The pyramid holds a box for every block, the vertices in float32, and what PyramidParts names.
// Boxes lie inside their parents' exactly: a minimum rounds nothing. They bound the vertices
// rounded to float32; the traversals widen them by what the rounding may have moved.
//
// A sphere has its centre in the middle of the box and holds the boxes of all leaf blocks of its
// block, so that spheres never part what boxes find. Its radius is the lesser of half the diagonal
// of the box and what holds the spheres of the children, on the four top levels those of the blocks
// of the sixth. Every float64 vertex lies inside.
//
// Can be moved, not copied. All const members may be called from many threads at once.
class Pyramid {
 public:
  // Coordinates of this size (metres) and beyond are treated like those that are not finite.
  static constexpr float coordinate_limit = 1e18F;
  // The most quads along an axis of a patch.
  static constexpr int quad_limit = 1 << 17;

  // Throws std::invalid_argument, naming the patch, on more than quad_limit quads along an axis.
  explicit Pyramid(const Atlas& atlas, const PyramidParts& parts = {});
  Pyramid(Pyramid&&) = default;
  Pyramid& operator=(Pyramid&&) = default;

  // Rebuilds everything from the positions (metres) of the atlas' particles, on `threads`
  // threads (0: those of OpenMP), with the same bits for any number of them. O(quads); allocates
  // nothing. Returns the first texel whose position is not finite (the pyramid is then not usable
  // until the next rebuild).
  [[nodiscard]] std::optional<TexelAddress> rebuild(std::span<const Vec3> positions,
                                                    int threads = 0);
  // Bounds every vertex at both ends of its path, and so all along a straight one. The first call
  // makes room for the second image.
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
    const int begin = block_boundary(u, patch_count(), level);
    return std::span(patch_order_)
        .subspan(begin, block_boundary(u + 1, patch_count(), level) - begin);
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
  // A run of rows of leaf blocks of a patch, bounded by one thread, with its rows in the making.
  struct Strip {
    int patch = 0;
    int index = 0;
    std::vector<float> rows;       // two of every level, and those of the columns of vertices
    std::vector<std::size_t> row;  // where the rows of a level begin
    std::size_t columns = 0;
    // The row of vertices shared with the next strip, at both ends of its path.
    std::array<std::vector<float>, 2> boundary;
    bool finite = true;
  };
  // The indices at which a level begins in the arrays.
  struct LevelPlace {
    std::size_t groups = 0;
    std::size_t tangents = 0;
  };
  // A block among the children of another.
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
  void split_patches(int level, int u);
  void rebuild_groups();
  void rebuild_spheres(int patch, int threads);
  void tighten_spheres(int patch);
  float& radius_of(int patch, int level, int u, int v);

  Atlas atlas_;
  PyramidParts parts_;
  std::vector<BoxPatch> patches_;
  std::vector<BoxLevel> levels_;
  std::vector<LevelPlace> places_;         // by level, as levels_
  std::vector<std::size_t> first_vertex_;  // by patch, into vertices_
  std::vector<int> strip_log_;             // by patch: log2 of its number of strips
  std::vector<std::int32_t> boundaries_;   // of the columns of leaf blocks, patch after patch
  std::vector<std::size_t> first_boundary_;
  int group_levels_ = 0;
  std::vector<std::int32_t> patch_order_;  // groups are runs of these
  bool is_ordered_ = false;
  std::vector<BoxGroup> groups_;
  std::vector<TangentBounds> tangents_;
  std::vector<SphereGroup> spheres_;  // as groups_, or none
  std::array<std::vector<float>, 2> vertices_;
  std::vector<Box> group_boxes_;
  std::vector<Strip> strips_;
  BoxTree tree_{};
  bool built_ = false;
  std::array<std::span<const Vec3>, 2> ends_;  // of the rebuild in progress
};

}  // namespace weft::bsi
