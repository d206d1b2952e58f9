// The borders that patches of a spline surface share.
#pragma once

#include <vector>

#include "bsi/geometry_image.h"

namespace weft::sim {

// A border that two patches share as a whole. The two may be one patch, joined to itself. Their
// surfaces meet in the spline curve with the control points `border`. `first` and `second` have the
// control points next to the border in the first and the second patch, in the same order. All are
// local indices.
struct PatchJoint {
  std::vector<int> border, first, second;
  bool is_closed = false;  // true if the border is a closed curve
};

// Returns the joints between the patches of an atlas, in the order of the first patches and their
// borders. Throws std::invalid_argument, with the index of the patch, if patches share only a part
// of a border, because their splines would not meet there. Preconditions: bsi::build_mesh() accepts
// the atlas, and each axis has at least three control points. Cost: O(n log n + sum of squared
// lengths of shared borders), with n border texels.
std::vector<PatchJoint> find_patch_joints(const bsi::Atlas& atlas);

}  // namespace weft::sim
