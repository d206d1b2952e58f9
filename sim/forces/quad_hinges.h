// The five hinges of a quad, which are its diagonal and its four sides, and the nodes across its
// sides.
#pragma once

#include <array>

#include "materials/hinge.h"

namespace weft::sim {

// The corners of a quad and the nodes across its sides. Within a patch, nodes 0 to 2 are
// consecutive in one row of the image, and nodes 3 to 5 in the next row. Corners 0, 1, 4 and 5 are
// in the order of quad_corners() in sim/forces/quads.h:
//
//         7
//     3 - 4 - 5
//         0 - 1 - 2
//             6
struct QuadSurroundings {
  static constexpr int count = 8;
  static constexpr bool follows(int node) {
    return node == 1 || node == 2 || node == 4 || node == 5;
  }
  // False if one node lies across a side of one triangle, and the other across a side of the other
  // triangle. The energy of a triangle depends only on the angles at its own sides, so neither
  // triangle's energy depends on both nodes.
  static constexpr bool couples(int a, int b) {
    const auto around_one = [](int node) { return node == 3 || node == 6; };
    const auto around_other = [](int node) { return node == 2 || node == 7; };
    return !(around_one(a) && around_other(b)) && !(around_other(a) && around_one(b));
  }
};
inline constexpr std::array<int, 4> quad_corner_nodes = {0, 1, 4, 5};

// Number of hinges, and the nodes of each hinge in the order of materials/hinge.h. Hinge 0 is the
// diagonal. The last two nodes of a side are the opposite corner of the quad and the node across
// the side.
inline constexpr int hinge_count = 5;
inline constexpr std::array<std::array<int, 4>, hinge_count> hinge_nodes = {
    {{1, 4, 0, 5}, {4, 0, 1, 3}, {0, 1, 4, 6}, {5, 4, 1, 7}, {1, 5, 4, 2}}};

// The nodes and hinges of a triangle of the quad. The i-th hinge is opposite the i-th node.
struct HingedTriangle {
  std::array<int, 3> nodes;
  std::array<int, 3> hinges;

  // Returns the index of `node` among the triangle's nodes, or -1 if it is not one of them.
  constexpr int own(int node) const {
    for (int i = 0; i < 3; ++i) {
      if (nodes[i] == node) return i;
    }
    return -1;
  }
  // Returns the index of the triangle's hinge across which `node` lies, or -1 if there is no such
  // hinge.
  constexpr int across(int node) const {
    if (own(node) >= 0) return -1;
    for (int i = 0; i < 3; ++i) {
      for (const int other : hinge_nodes[hinges[i]]) {
        if (other == node) return i;
      }
    }
    return -1;
  }
};
inline constexpr std::array<HingedTriangle, 2> hinged_triangles = {
    {{{0, 1, 4}, {0, 1, 2}}, {{1, 5, 4}, {3, 0, 4}}}};

// The derivatives d angle / d x of a quad's hinge angles by the node positions, 1/m.
template <class Real>
class QuadSlopes {
 public:
  using Nodes = materials::NodesOf<Real, QuadSurroundings::count>;
  using Vec3 = materials::Vec3Of<Real>;
  using Hinges = std::array<Real, hinge_count>;

  explicit QuadSlopes(const std::array<materials::HingeVectorsOf<Real>, hinge_count>& hinges) {
    for (int h = 0; h < hinge_count; ++h) gradient_[h] = materials::hinge_gradient(hinges[h]);
  }

  // Returns the changes of the angles if the nodes move by u. These are sums over nodes of the
  // products (d angle / d x) . u.
  Hinges along(const Nodes& u) const {
    Hinges change;
    for (int h = 0; h < hinge_count; ++h) {
      change[h] = 0;
      for (int k = 0; k < 4; ++k)
        change[h] += materials::dot(gradient_[h].col(k), u.col(hinge_nodes[h][k]));
    }
    return change;
  }
  // Returns the sum over hinges of moment times d angle / d x, by node.
  Nodes times(const Hinges& moments) const {
    Nodes sum = Nodes::Zero();
    for (int h = 0; h < hinge_count; ++h) {
      for (int k = 0; k < 4; ++k) sum.col(hinge_nodes[h][k]) += moments[h] * gradient_[h].col(k);
    }
    return sum;
  }

  // Returns the derivative of the i-th hinge angle of a triangle by the position of one node of the
  // hinge.
  template <int triangle, int i, int node>
  Vec3 of() const {
    constexpr int hinge = hinged_triangles[triangle].hinges[i];
    constexpr int place = [] {
      for (int k = 0; k < 4; ++k) {
        if (hinge_nodes[hinge][k] == node) return k;
      }
      return -1;
    }();
    static_assert(place >= 0);
    return gradient_[hinge].col(place);
  }

 private:
  std::array<materials::NodesOf<Real, 4>, hinge_count> gradient_;
};

}  // namespace weft::sim
