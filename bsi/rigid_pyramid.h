// The pyramid of a body that moves without changing its shape. It is built once in the body's own
// frame, and its blocks are placed in space while a traversal visits them.
#pragma once

#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// A rigid placement: a point p of the body's frame lies at rotation * p + translation, m.
struct RigidFrame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation{0, 0, 0};
  // The sums run from left to right, as in the kernels: both round alike.
  Vec3 place(const Vec3& p) const {
    Vec3 placed;
    for (int i = 0; i < 3; ++i) {
      placed[i] =
          rotation(i, 0) * p[0] + rotation(i, 1) * p[1] + rotation(i, 2) * p[2] + translation[i];
    }
    return placed;
  }
};

// The tree of a rigid pyramid in space. It refers to the pyramid and to its own placement, so it
// can be neither moved nor copied.
struct PlacedTree {
  PlacedTree() = default;
  PlacedTree(const PlacedTree&) = delete;
  PlacedTree& operator=(const PlacedTree&) = delete;
  BoxTree tree{};
  BoxPlacement placement{};
  // Distance (m) by which the box of a leaf in space may exceed the placed sphere of its block.
  double beyond_spheres = 0;
};

// Boxes rotate with their blocks, which enlarges them by up to the square root of three: a query
// tests more blocks than in a rebuilt pyramid. The boxes of the leaves are made from the placed
// vertices and decide the result, which is the same.
//
// Rounding is proportional to the largest coordinate in the frame and to the translation. It is
// least if the body lies around the origin of its frame.
class RigidPyramid {
 public:
  // `positions` are those of the particles in the body's frame, m, finite and below
  // Pyramid::coordinate_limit. There are no bounds of steps: a body that keeps its shape needs no
  // self traversal.
  RigidPyramid(const Atlas& atlas, std::vector<Vec3> positions, bool spheres, int threads = 0);

  const Pyramid& pyramid() const { return pyramid_; }
  std::span<const Vec3> positions() const { return positions_; }
  // Places the tree by one frame, or by the frames of both ends of a step. Its boxes then bound
  // every vertex at both ends, and on the straight path between them.
  void place(std::span<const RigidFrame> ends, PlacedTree& placed) const;

 private:
  Pyramid pyramid_;
  std::vector<Vec3> positions_;
  double radius_ = 0;        // m, largest distance of a particle from the origin of the frame
  double largest_quad_ = 0;  // m, largest distance of two corners of a quad
};

// Returns a box in space around the placed box `own` of the frame. It contains the box that the
// kernels make.
Box placed_box(const BoxTree& tree, const Box& own);

}  // namespace weft::bsi
