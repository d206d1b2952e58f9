// One axis of a patch on the levels of the multigrid.
#pragma once

#include <vector>

namespace weft::sim {

// One axis of a patch on one level of the multigrid. Its nodes are the texels that the level keeps
// or, for a spline, the control points of the level.
//
// On the finest level, the axis has `quads` intervals: those between texels, or the elements of a
// spline. A level has `intervals` intervals, with ends at round(j quads / intervals), j = 0 ..
// intervals. All of them are also interval ends of the next finer level. The splines of a level are
// therefore also splines of all finer levels. The first coarser level has about quads / 2
// intervals, and each further level has half the intervals of the level before.
struct CoarseAxis {
  int quads = 0;      // intervals on the finest level
  int intervals = 0;  // intervals on this level
  bool wraps = false;
  int degree = 0;  // degree of the spline; 0: values at texels, with linear interpolation

  // A coarse node and its weight in the interpolation to one fine node. The weights of a fine node
  // sum to 1.
  struct Share {
    int node = 0;
    double weight = 0;
  };

  // Returns the texel, or the knot, at the start of an interval. Beyond the ends, a closed axis
  // continues periodically, and an open axis returns its end.
  int start(int interval) const;
  int nodes() const { return wraps ? intervals : intervals + (degree > 0 ? degree : 1); }
  bool can_be_coarsened() const;
  // Returns the axis of the next coarser level. Precondition: can_be_coarsened().
  CoarseAxis coarser() const;

  // Returns, for each node of a coarser axis, the nearest node of this axis, in ascending order and
  // without repetition. Nodes across the seam of a closed axis are not considered. The nearest node
  // of an end of an open axis is an end. Mirrored nodes of an open axis have mirrored nearest
  // nodes, except for a node in the middle.
  std::vector<int> nearest_nodes(const CoarseAxis& coarse) const;
  // Returns, for each node of this axis, the coarse nodes from which it is interpolated, in
  // ascending order of their positions. Texels are interpolated linearly. Control points follow
  // from knot insertion, which reproduces the coarse spline.
  std::vector<std::vector<Share>> shares(const CoarseAxis& coarse) const;

 private:
  int knot(int i) const { return start(i - degree); }
  double centre(int node) const;
  std::vector<Share> spline_share(const CoarseAxis& coarse, int node) const;
};

}  // namespace weft::sim
