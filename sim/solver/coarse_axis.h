// One axis of a patch on the levels of the multigrid.
#pragma once

#include <vector>

namespace weft::sim {

// The nodes that a level keeps along one axis of a patch, or, of a spline, its control points there.
//
// The axis has `quads` intervals between the texels of the patch, or elements of its spline. A level
// has `intervals` of them, whose ends are at round(j quads / intervals), j = 0 .. intervals: among
// the ends of the next finer level. The first number is near half of `quads`; it halves from level to
// level. Hence the splines of a level are splines of all finer ones, too.
struct CoarseAxis {
  int quads = 0;      // of the patch
  int intervals = 0;  // of the level
  bool wraps = false;
  int degree = 0;  // of a spline; 0: values at texels, with linear interpolation

  // Weights of coarse nodes in a fine one; they sum to 1.
  struct Share {
    int node = 0;
    double weight = 0;
  };

  // Returns the texel, or the knot, at the start of an interval. Beyond its ends a closed axis goes
  // on, and an open one stays.
  int start(int interval) const;
  int nodes() const { return wraps ? intervals : intervals + (degree > 0 ? degree : 1); }
  bool can_be_coarsened() const;
  // Returns the axis of the next coarser level. Precondition: can_be_coarsened().
  CoarseAxis coarser() const;

  // Returns the fine node nearest to each node of a coarser axis, in ascending order. Ends belong to
  // ends. But for a node in the middle, mirror images belong to mirror images.
  std::vector<int> nearest_nodes(const CoarseAxis& coarse) const;
  // Returns the shares of a coarser axis by fine node, in ascending order of parameters: by linear
  // interpolation, or those with which the coarse spline becomes one of the fine axis.
  std::vector<std::vector<Share>> shares(const CoarseAxis& coarse) const;

 private:
  int knot(int i) const { return start(i - degree); }
  double centre(int node) const;
  std::vector<Share> spline_share(const CoarseAxis& coarse, int node) const;
};

}  // namespace weft::sim
