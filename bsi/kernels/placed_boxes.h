// Boxes, spheres and vertices of a tree in the frame of a rigid body, placed in space when a
// descent visits them. For kernel files only, like box_lanes.h.
//
// The functions that place blocks are not inlined. Descents of trees built in space then pay only
// for tests of BoxTree::placement.
#pragma once

#include "bsi/detail/box_layout.h"
#include "bsi/kernels/box_lanes.h"
#include "bsi/kernels/leaf_quads.h"

namespace weft::bsi::WEFT_KERNELS {

// Computes boxes in space that contain four boxes of the frame. Centres are rotated by R. Half
// extents are multiplied by the magnitudes of the elements of R, because a corner may rotate in any
// direction. The boxes of both ends of the path are joined, and the rounding of the placement is
// added. An absent child keeps low > high.
[[gnu::noinline]] static void place_boxes(const BoxTree& tree, const BoxGroup& own,
                                          BoxGroup& placed) {
  const BoxPlacement& placement = *tree.placement;
  Quad centre[3], half[3];
  for (int axis = 0; axis < 3; ++axis) {
    const Quad low = load_quad(own.low[axis]), high = load_quad(own.high[axis]);
    centre[axis] = 0.5F * (low + high);
    half[axis] = larger(high - centre[axis], centre[axis] - low);
  }
  for (int end = 0; end <= tree.swept; ++end) {
    for (int axis = 0; axis < 3; ++axis) {
      Quad middle = Quad{} + placement.translation_float[end][axis];
      Quad reach = Quad{} + placement.rounding;
      for (int k = 0; k < 3; ++k) {
        const float factor = placement.rotation_float[end][axis][k];
        middle += factor * centre[k];
        reach += __builtin_fabsf(factor) * half[k];
      }
      Quad low = middle - reach, high = middle + reach;
      if (end > 0) {
        low = smaller(low, load_quad(placed.low[axis]));
        high = larger(high, load_quad(placed.high[axis]));
      }
      *reinterpret_cast<UnalignedQuad*>(placed.low[axis]) = low;
      *reinterpret_cast<UnalignedQuad*>(placed.high[axis]) = high;
    }
  }
}

// Places four spheres at the end of the path. Leaf boxes may extend beyond the placed spheres;
// DescentQuery::sphere_reach allows for that.
[[gnu::noinline]] static void place_spheres(const BoxTree& tree, const SphereGroup& own,
                                            SphereGroup& placed) {
  const BoxPlacement& placement = *tree.placement;
  for (int axis = 0; axis < 3; ++axis) {
    Quad centre = Quad{} + placement.translation_float[1][axis];
    for (int k = 0; k < 3; ++k)
      centre += placement.rotation_float[1][axis][k] * load_quad(own.centre[k]);
    *reinterpret_cast<UnalignedQuad*>(placed.centre[axis]) = centre;
  }
  *reinterpret_cast<UnalignedQuad*>(placed.radius) = load_quad(own.radius);
}

// The vertices of a leaf block in space, by component, m. Vertex (r, c) is at index 4 r + c.
struct PlacedVertices {
  float component[3][16];
};

// Places the vertices of a leaf block in float64. Rounds them to float32 like Pyramid::rebuild().
[[gnu::noinline]] static void place_vertices(const BoxTree& tree, const BoxPatch& patch,
                                             const LeafQuads& quads, int end,
                                             PlacedVertices& vertices) {
  const BoxPlacement& placement = *tree.placement;
  vertices = {};
  for (int r = 0; r <= quads.rows; ++r) {
    const int row = quads.row + r < patch.rows ? quads.row + r : 0;
    for (int c = 0; c <= quads.cols; ++c) {
      const int col = quads.col + c < patch.cols ? quads.col + c : 0;
      const int texel = patch.first_texel + row * patch.cols + col;
      const int particle =
          tree.texel_to_particle == nullptr ? texel : tree.texel_to_particle[texel];
      const double* p = placement.positions + 3 * static_cast<std::size_t>(particle);
      for (int axis = 0; axis < 3; ++axis) {
        const double* turn = placement.rotation[end][axis];
        vertices.component[axis][4 * r + c] = static_cast<float>(
            turn[0] * p[0] + turn[1] * p[1] + turn[2] * p[2] + placement.translation[end][axis]);
      }
    }
  }
}

// Returns `group` if the tree was built in space. Otherwise places the group in `room` and returns
// `room`.
WEFT_INLINE const BoxGroup& in_space(const BoxTree& tree, const BoxGroup& group, BoxGroup& room) {
  if (__builtin_expect(static_cast<long>(tree.placement == nullptr), 1) != 0) return group;
  place_boxes(tree, group, room);
  return room;
}
WEFT_INLINE const SphereGroup& in_space(const BoxTree& tree, const SphereGroup& group,
                                        SphereGroup& room) {
  if (__builtin_expect(static_cast<long>(tree.placement == nullptr), 1) != 0) return group;
  place_spheres(tree, group, room);
  return room;
}

}  // namespace weft::bsi::WEFT_KERNELS
