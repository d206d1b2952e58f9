// The pyramid of a body that moves without changing its shape. It is built once in the body's own
// frame. A traversal places its blocks in space as it visits them.
#pragma once

#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// A placement of a rigid body: point p of the body's frame lies at rotation * p + translation, m.
struct RigidFrame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation{0, 0, 0};
  // Returns the position (m) in space of point p. The terms are summed from left to right, as in
  // the kernels, so that both results round alike.
  Vec3 place(const Vec3& p) const {
    Vec3 placed;
    for (int i = 0; i < 3; ++i) {
      placed[i] =
          rotation(i, 0) * p[0] + rotation(i, 1) * p[1] + rotation(i, 2) * p[2] + translation[i];
    }
    return placed;
  }
};

// The tree of a rigid pyramid, placed in space. `tree` points to the pyramid's data and to
// `placement`, so the object can be neither moved nor copied.
struct PlacedTree {
  PlacedTree() = default;
  PlacedTree(const PlacedTree&) = delete;
  PlacedTree& operator=(const PlacedTree&) = delete;
  BoxTree tree{};
  BoxPlacement placement{};
  // Upper bound (m) of how far the axis-aligned box of a placed leaf extends beyond the placed
  // sphere of its block. It has no meaning without spheres.
  double beyond_spheres = 0;
};

// A pyramid in the frame of a rigid body. In space, a rotated box is enclosed in an axis-aligned
// box, which is larger in general. A query may therefore test more blocks than in a rebuilt
// pyramid. The result is the same, because the boxes of the leaves come from placed vertices.
//
// Rounding errors grow with the largest coordinate in the frame and with the translation. They are
// smallest if the body lies around the origin of its frame.
class RigidPyramid {
 public:
  // `positions` are the particles' positions in the body's frame, m. Throws std::invalid_argument
  // unless all coordinates are finite and below Pyramid::coordinate_limit in magnitude. The pyramid
  // has no bounds of steps, because a body that keeps its shape needs no self traversal.
  RigidPyramid(const Atlas& atlas, std::vector<Vec3> positions, bool spheres, int threads = 0);

  const Pyramid& pyramid() const { return pyramid_; }
  std::span<const Vec3> positions() const { return positions_; }
  // Places the tree by one frame, or by the frames at the start and the end of a path. With two
  // frames, boxes bound every vertex at both ends and on the straight path between them. `placed`
  // keeps pointers to data of this object. Preconditions: rotations are orthonormal to rounding,
  // and the placed boxes stay within Pyramid::coordinate_limit.
  void place(std::span<const RigidFrame> ends, PlacedTree& placed) const;

 private:
  Pyramid pyramid_;
  std::vector<Vec3> positions_;
  double radius_ = 0;        // m, largest distance of a particle from the frame's origin
  double largest_quad_ = 0;  // m, largest distance of two corners of a quad; 0 without spheres
};

// Returns a box in space that contains the box `own` of the frame at each end of the path (only at
// the start if `tree` is not swept). It also contains the box that the kernels compute for `own`.
// Precondition: `tree` has a placement.
Box placed_box(const BoxTree& tree, const Box& own);

}  // namespace weft::bsi
