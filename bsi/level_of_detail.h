// Level of detail: coarse surfaces without cracks, made from the spheres of a pyramid.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

// A triangle surface that approximates an atlas (construction: docs/theory.md, "Level of detail").
// It has the orientation and the topology of the original surface. Its open edges lie along borders
// of the original, and each border keeps at least one vertex.
struct DetailSurface {
  std::vector<Vec3> positions;                // vertices, m
  std::vector<std::array<int, 3>> triangles;  // three indices in `positions` each
  // The particle at the same place of the image, for each vertex. A vertex can take its normal or
  // colour from this particle.
  std::vector<int> particles;
  // Upper bound (m) of the Hausdorff distance to the original surface.
  double deviation = 0;
};

// The largest allowed distance between the coarse and the original surface. It is `most` (m) or
// `per_distance` times the distance from the point `eye` (m), whichever is smaller.
struct DetailTolerance {
  double most = std::numeric_limits<double>::infinity();
  double per_distance = std::numeric_limits<double>::infinity();
  Vec3 eye = Vec3::Zero();
  double at(const Vec3& point) const {
    return std::min(most, per_distance * (point - eye).norm());  // `most` if the product is NaN
  }
};

// Makes a surface through the sphere centres of all blocks on level levels[p] of each patch p, and
// through original vertices on the borders of patches. A block with a single texel takes the vertex
// of that texel instead of its centre. A border keeps the vertices where patches begin or end.
// Between them it keeps at least one sample per joint of two blocks along the border. At a seam,
// the patch with the finest blocks determines the samples. `deviation` is the largest radius of a
// sphere used or the largest distance of a border vertex from its sample, whichever is larger.
//
// Beyond its last level a patch keeps its original surface. So does a patch that has no inner
// texel, has fewer than five quads around a wrapped axis, or has two texels with the same particle.
// So does a patch with an inner texel that is sewn to another patch. A wrapped axis needs three
// blocks, so levels 0 and 1 of a wrapped patch count as 2. Preconditions: the pyramid is built from
// `positions` (m, by particle) and has spheres; one level per patch. O(texels x levels).
DetailSurface detail_at_levels(const Pyramid& pyramid, std::span<const Vec3> positions,
                               std::span<const int> levels);

// Makes a surface from blocks of different levels within each patch, and from all vertices on the
// borders of patches. The counterpart of a coarse point is the original point at the same place of
// the image. Both surfaces are linear on the pieces into which their edges cut the image. Blocks
// are split until every corner of a piece is within the tolerance of its counterpart. If
// `per_distance` is infinite, so is every other point. `deviation` bounds the distances of all
// points from their counterparts. A tolerance of 0 gives the original surface. Precondition: the
// pyramid is built from `positions` (m, by particle). At most O(texels x levels). Patches are
// shared among the threads of OpenMP, whose number does not change the result.
DetailSurface detail_within(const Pyramid& pyramid, std::span<const Vec3> positions,
                            const DetailTolerance& tolerance);

// Returns the largest distance (m) between a point of the surface that detail_at_levels() makes and
// its counterpart (see detail_within()). On a smooth surface it is much smaller than
// DetailSurface::deviation. Preconditions as for detail_at_levels(), but spheres are not needed. At
// most O(texels x levels).
double deviation_at_levels(const Pyramid& pyramid, std::span<const Vec3> positions,
                           std::span<const int> levels);

}  // namespace weft::bsi
