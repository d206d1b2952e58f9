// Level of detail: coarser surfaces without cracks, whose vertices are centres of a pyramid's
// spheres.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// A triangle surface that approximates an atlas (construction: docs/theory.md, "Level of detail").
// It has the orientation and the topology of the original. It has open edges only along borders of
// the original, and at least one vertex on each border.
struct DetailSurface {
  std::vector<Vec3> positions;  // m
  std::vector<std::array<int, 3>> triangles;
  // By vertex: the particle at its place in the image. The vertex can use the particle's normal or
  // colour.
  std::vector<int> particles;
  // Upper bound of the Hausdorff distance to the original surface, m.
  double deviation = 0;
};

// Largest allowed distance between the coarse and the original surface: `most` (m) or
// `per_distance` times the distance from the eye, whichever is smaller.
struct DetailTolerance {
  double most = std::numeric_limits<double>::infinity();
  double per_distance = std::numeric_limits<double>::infinity();
  Vec3 eye = Vec3::Zero();
  double at(const Vec3& point) const {
    return std::min(most, per_distance * (point - eye).norm());  // `most` if 0 x infinity is NaN
  }
};

// Makes the surface through the sphere centres of all blocks on level levels[p] of each patch p,
// and through original vertices on the borders of patches. These border vertices are the points
// where patches begin or end and, in between, one sample per joint of two blocks along the border.
// At a seam, the blocks of the finer patch determine the samples. The deviation is the largest
// radius of a sphere whose centre is used, or the largest distance of a border vertex from its
// sample, if that is larger.
//
// Beyond its last level a patch keeps its original surface. So does a patch that is sewn to itself,
// wraps fewer than five quads or has no inner texel. A wrapped axis needs three blocks, so levels 0
// and 1 of a wrapped patch count as 2. Preconditions: pyramid.is_built(), from `positions`, with
// spheres. O(texels).
DetailSurface detail_at_levels(const Pyramid& pyramid, std::span<const Vec3> positions,
                               std::span<const int> levels);

// Makes the surface from blocks of different levels within each patch, and all vertices on the
// borders of patches. Blocks are split until every point lies within the tolerance of its
// counterpart: the original point at the same place in the image. The deviation bounds these
// distances. A tolerance of 0 gives the original surface. Precondition: pyramid.is_built(), from
// `positions`. O(texels x levels), less where the surface is rough. OpenMP's threads share the
// patches; their number does not change the result.
DetailSurface detail_within(const Pyramid& pyramid, std::span<const Vec3> positions,
                            const DetailTolerance& tolerance);

// Returns the largest distance (m) between a point of detail_at_levels() and its counterpart. On a
// smooth surface it is much smaller than DetailSurface::deviation. Up to O(texels x levels).
double deviation_at_levels(const Pyramid& pyramid, std::span<const Vec3> positions,
                           std::span<const int> levels);

}  // namespace weft::bsi
