// Coarser and coarser images of the dynamic bodies, and the interpolations between them: the
// geometry of the multigrid.
//
// Every level keeps texels of the finer one, or knots of its splines, whatever the size of the image
// (coarse_axis.h). Both axes of a patch are coarsened together, until one of them cannot be.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Interpolates from the nodes of a level to those of the next finer one: fine = sum of weight *
// coarse.
struct Prolongation {
  int fine_count() const { return static_cast<int>(row_start.size()) - 1; }
  int coarse_count() const { return static_cast<int>(child_start.size()) - 1; }

  // Rows by fine node: the coarse nodes that it is interpolated from (ascending), at most four with
  // bilinear weights in texels or, of cubic splines, sixteen control points. A fixed node has none.
  // The weights sum to 1, unless coarse nodes are left out because only fixed nodes depend on them.
  std::vector<int> row_start, column;
  std::vector<float> weight;
  // The transpose by coarse node: its fine nodes, at least one, in ascending order.
  std::vector<int> child_start, child;
  std::vector<float> child_weight;

  // coarse = transpose * fine, and fine += this * coarse.
  void restrict_to(std::span<const Vec3> fine, std::span<Vec3> coarse, int threads) const;
  void add_to(std::span<const Vec3> coarse, std::span<Vec3> fine, int threads) const;
};

// Returns one prolongation per coarser level of the dynamic bodies, finest first. If nothing can be
// coarsened, there is one, from a level of all free particles. A particle that several patches
// share has one node on every level that keeps it. O(texels).
std::vector<Prolongation> coarsen_images(const Scene& scene);

}  // namespace weft::sim
