// Level of detail: surfaces of fewer triangles from the sphere centres of a pyramid, without
// cracks.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// A triangle surface that stands for an atlas, made as docs/theory.md, section 8, says. It has the
// orientation and the topology of the original: it has open edges only along borders of the
// original, and at least one vertex on each of these.
struct DetailSurface {
  std::vector<Vec3> positions;  // m
  std::vector<std::array<int, 3>> triangles;
  // By vertex: the particle at its place in the image, whose normal or colour it can take over.
  std::vector<int> particles;
  // Every point of either surface has a point of the other within this distance, m.
  double deviation = 0;
};

// How far a surface may stray: `most` (m) anywhere, and `per_distance` x the distance from the eye.
struct DetailTolerance {
  double most = std::numeric_limits<double>::infinity();
  double per_distance = std::numeric_limits<double>::infinity();
  Vec3 eye = Vec3::Zero();
  double at(const Vec3& point) const {
    return std::min(most, per_distance * (point - eye).norm());  // most where 0 x infinity is NaN
  }
};

// Makes the surface through sphere centres of blocks, on level levels[p] of patch p, and original
// vertices of the borders. Those are the vertices where patches begin or end, and samples between:
// one per joint of two blocks along the border. At a seam the finer patch's blocks count. Beyond
// the last level of a patch it is the original surface. A wrapped axis has at least three blocks:
// there levels 0 and 1 count as 2. A patch that is sewn to itself, wraps fewer than five quads or
// has no texel inside keeps its original surface. The stated deviation is the largest radius of a
// sphere whose centre is used, or the largest distance of a border's vertex from its sample.
// Precondition: pyramid.is_built(), from `positions`, with spheres. O(texels).
DetailSurface detail_at_levels(const Pyramid& pyramid, std::span<const Vec3> positions,
                               std::span<const int> levels);

// Makes the surface from blocks of different levels within each patch, and all vertices of the
// borders of patches. Blocks are split until every point lies within the tolerance of its
// counterpart: the original point at the same place in the image. The stated deviation bounds those
// distances. With a tolerance of 0 it is the original surface. O(texels x levels), less where the
// surface is rough. The threads of OpenMP share the patches, with the same result from any number
// of them.
DetailSurface detail_within(const Pyramid& pyramid, std::span<const Vec3> positions,
                            const DetailTolerance& tolerance);

// The largest distance of the points of detail_at_levels from their counterparts, m: much smaller
// than its stated deviation where the surface is smooth. Up to O(texels x levels).
double deviation_at_levels(const Pyramid& pyramid, std::span<const Vec3> positions,
                           std::span<const int> levels);

}  // namespace weft::bsi
