// The levels of multigrid: coarser images of the dynamic bodies, and the interpolations between
// them.
//
// Every level keeps some texels of the next finer level, or knots of its splines, for any size of
// image (coarse_axis.h). Both axes of a patch are coarsened together. A patch with an axis that is
// too short is not coarsened further.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Interpolation from the nodes of a level to those of the next finer level: fine = sum of weight *
// coarse.
struct Prolongation {
  int fine_count() const { return static_cast<int>(row_start.size()) - 1; }
  int coarse_count() const { return static_cast<int>(child_start.size()) - 1; }

  // Compressed rows, one per fine node: the coarse nodes from which the fine node is interpolated
  // (ascending), with weights. A texel has up to four coarse nodes with bilinear weights, by
  // distances in texels. A control point has up to sixteen, with the weights of knot insertion.
  // Rows of fixed nodes are empty. The weights of other rows sum to 1, unless coarse nodes are left
  // out because only fixed nodes depend on them.
  std::vector<int> row_start, column;
  std::vector<float> weight;
  // The transpose, one row per coarse node: the fine nodes interpolated from it (ascending, at
  // least one), with weights.
  std::vector<int> child_start, child;
  std::vector<float> child_weight;

  // restrict_to() computes coarse = transpose * fine. add_to() computes fine += this * coarse.
  void restrict_to(std::span<const Vec3> fine, std::span<Vec3> coarse, int threads) const;
  void add_to(std::span<const Vec3> coarse, std::span<Vec3> fine, int threads) const;
};

// Returns the prolongations between the levels, finest first. If no image can be coarsened, there
// is one prolongation, from a coarse level that has a node for every free particle. A particle that
// belongs to several patches has one node on every level that keeps it. Cost: O(texels).
std::vector<Prolongation> coarsen_images(const Scene& scene);

}  // namespace weft::sim
