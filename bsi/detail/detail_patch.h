// A patch of a surface of reduced detail, with a vertex assigned to each texel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// A corner of a coarse triangle. A `vertex` below texel_count() is the original vertex at that
// texel of the patch. Any other `vertex` is the centre of block `vertex` - texel_count(). (row,
// col) is the vertex's position in the image; along a wrapped axis it may lie outside the image.
struct DetailCorner {
  int vertex = 0;
  double row = 0;
  double col = 0;
};
using DetailTriangle = std::array<DetailCorner, 3>;

// Returns twice the signed area of a triangle in the image. The area of an inverted triangle is
// negative.
inline double image_area(const DetailTriangle& triangle) {
  const auto& [a, b, c] = triangle;
  return (b.col - a.col) * (c.row - a.row) - (c.col - a.col) * (b.row - a.row);
}

// A patch that assigns a vertex to every texel. A texel of a block gets the centre of the block's
// sphere, unless it is the block's only texel. After sample_borders(), a texel of an open border
// has a sample of that border. Any other texel keeps its own vertex. The coarse surface consists of
// the quads' triangles with three different vertices. It is the dual of the partition of the image
// into rectangles and stretches of the border.
class DetailPatch {
 public:
  // Starts with the blocks of level 0, or of level 2 if an axis is wrapped: fewer than three blocks
  // around an axis would fold the surface. Blocks with fewer than two texels are left out. If
  // `as_it_is`, starts without blocks.
  DetailPatch(const Pyramid& pyramid, int patch, bool as_it_is);

  int texel_count() const { return size_.texel_count(); }
  const PatchBlock& block(int vertex) const { return blocks_[vertex - texel_count()].block; }
  // Returns the texel in the middle of a block. For a vertex that is not a block, returns the
  // vertex itself.
  int middle_texel(int vertex) const;
  bool is_block(int vertex) const { return vertex >= texel_count(); }
  int block_count() const { return static_cast<int>(blocks_.size()); }

  // Replaces the vertices of open borders by their samples. `sample_of`, by particle, is the result
  // of sampled_borders().
  void sample_borders(std::span<const int> sample_of);
  // Splits every block coarser than `level` into blocks of `level`. If the patch has no such level,
  // splits its blocks into texels. Precondition: no block has been split before.
  void split_to_level(int level);
  // Replaces a block by its children, or a leaf block by its texels. The number of the block is not
  // reused.
  void split(int vertex);

  // Calls visit(const DetailTriangle&) for each triangle, in the order of the quads.
  template <class Visit>
  void for_each_triangle(const Visit& visit) const;

 private:
  struct PlacedBlock {
    PatchBlock block;
    double row = 0;  // row of the block's middle in the image
    double col = 0;  // column of the block's middle in the image
  };

  // Returns the texels that belong to a block. Texels of open borders belong to no block.
  QuadRange texels_of(const PatchBlock& block) const;
  void add(const PatchBlock& block);
  void release(const PatchBlock& block);
  DetailCorner corner(int vertex, int texel_row, int texel_col) const;

  const Pyramid& pyramid_;
  int patch_;
  Patch size_;
  std::vector<int> vertex_of_;  // vertex assigned to each texel
  std::vector<PlacedBlock> blocks_;
};

// Returns the shift (0, `size` or -`size`) that moves a vertex next to its texel along a wrapped
// axis of `size` texels. `way` is the row or column of the texel minus that of the vertex. Unless
// the wrap lies between them, texel and vertex are at most size / 2 apart.
inline double turns(double way, int size) {
  if (2 * way > size) return size;
  return 2 * way < -size ? -size : 0;
}

// Returns the corner that `vertex` gives to the texel at (texel_row, texel_col). Either index may
// be one past the end of a wrapped axis.
inline DetailCorner DetailPatch::corner(int vertex, int texel_row, int texel_col) const {
  DetailCorner place{vertex, 0, 0};
  if (is_block(vertex)) {
    const PlacedBlock& placed = blocks_[vertex - texel_count()];
    place.row = placed.row;
    place.col = placed.col;
  } else {
    const int row = vertex / size_.cols;
    place.row = row;
    place.col = vertex % size_.cols;
  }
  place.row += turns(texel_row - place.row, size_.rows);
  place.col += turns(texel_col - place.col, size_.cols);
  return place;
}

template <class Visit>
void DetailPatch::for_each_triangle(const Visit& visit) const {
  for (int row = 0; row < size_.quad_rows(); ++row) {
    const int* upper = &vertex_of_[static_cast<std::size_t>(row) * size_.cols];
    const int* lower = row + 1 == size_.rows ? vertex_of_.data() : upper + size_.cols;
    for (int col = 0; col < size_.quad_cols(); ++col) {
      const int next = col + 1 == size_.cols ? 0 : col + 1;
      const std::array<int, 4> vertex{upper[col], upper[next], lower[col], lower[next]};
      if (vertex[1] == vertex[2]) continue;  // neither triangle has three different vertices
      const bool first = vertex[0] != vertex[1] && vertex[0] != vertex[2];
      const bool second = vertex[3] != vertex[1] && vertex[3] != vertex[2];
      if (!first && !second) continue;
      const std::array<DetailCorner, 4> at{
          corner(vertex[0], row, col), corner(vertex[1], row, col + 1),
          corner(vertex[2], row + 1, col), corner(vertex[3], row + 1, col + 1)};
      DetailTriangle upper_left{at[0], at[1], at[2]};
      DetailTriangle lower_right{at[1], at[3], at[2]};
      if (first && second && (image_area(upper_left) <= 0 || image_area(lower_right) <= 0)) {
        // The middles of four blocks, unlike four texels, may form a quad that is not convex. Only
        // the other diagonal then lies inside the quad.
        upper_left = {at[0], at[1], at[3]};
        lower_right = {at[0], at[3], at[2]};
      }
      if (first) visit(upper_left);
      if (second) visit(lower_right);
    }
  }
}

}  // namespace weft::bsi
