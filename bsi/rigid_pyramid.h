// The pyramid of a body that moves without changing its shape: built once in the body's own frame,
// it is put in place block by block while a traversal visits it.
#pragma once

#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// A rigid placement: a point p of the body's frame lies at rotation * p + translation, m.
struct RigidFrame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation{0, 0, 0};
  // The sums run from left to right, as in the kernels, so that both round alike.
  Vec3 place(const Vec3& p) const {
    Vec3 placed;
    for (int i = 0; i < 3; ++i) {
      placed[i] =
          rotation(i, 0) * p[0] + rotation(i, 1) * p[1] + rotation(i, 2) * p[2] + translation[i];
    }
    return placed;
  }
};

// The tree of a rigid pyramid in space. It refers to the pyramid and to its own placement: it can
// be neither moved nor copied.
struct PlacedTree {
  PlacedTree() = default;
  PlacedTree(const PlacedTree&) = delete;
  PlacedTree& operator=(const PlacedTree&) = delete;
  BoxTree tree{};
  BoxPlacement placement{};
  // How far, m, the box of a leaf in space may reach beyond the placed sphere of its block.
  double beyond_spheres = 0;
};

// Boxes are turned with their blocks, so that they grow by up to the square root of three: a query
// tests more blocks than in a pyramid that was rebuilt. The boxes of the leaves are made from the
// placed vertices and settle what is found, which is the same.
//
// Rounding is least where the body lies around the origin of its frame: it goes with the largest
// coordinate there, and with the translation.
class RigidPyramid {
 public:
  // `positions`: of the particles in the body's frame, m, finite and below
  // Pyramid::coordinate_limit. The bounds of steps are left out: a body that keeps its shape is
  // not asked for contact with itself.
  RigidPyramid(const Atlas& atlas, std::vector<Vec3> positions, bool spheres, int threads = 0);

  const Pyramid& pyramid() const { return pyramid_; }
  std::span<const Vec3> positions() const { return positions_; }
  // Places the tree by one frame, or by the frames of both ends of a step. Its boxes then bound
  // every vertex at both ends, and so on the straight path between them.
  void place(std::span<const RigidFrame> ends, PlacedTree& placed) const;

 private:
  Pyramid pyramid_;
  std::vector<Vec3> positions_;
  double radius_ = 0;        // m, of the particles about the origin of the frame
  double largest_quad_ = 0;  // m, between two corners
};

// Returns a box of the frame as it lies in space, no smaller than the kernels make it.
Box placed_box(const BoxTree& tree, const Box& own);

}  // namespace weft::bsi
