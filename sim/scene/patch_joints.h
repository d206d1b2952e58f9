// Borders that patches of a spline surface share.
#pragma once

#include <vector>

#include "bsi/geometry_image.h"

namespace weft::sim {

// A whole border of two patches. Their surfaces meet in the spline through the control points of
// `border`; those of `first` and `second` lie beside them in either patch (local indices).
struct PatchJoint {
  std::vector<int> border, first, second;
  bool is_closed = false;  // the curve is
};

// Returns the joints between the patches of an atlas, in the order of the first patch and its
// borders. Throws std::invalid_argument, naming the patch, if patches share a part of a border
// only: their splines would not meet there. Precondition: bsi::build_mesh() accepts the atlas, and
// each axis has three control points. O(border texels log border texels).
std::vector<PatchJoint> find_patch_joints(const bsi::Atlas& atlas);

}  // namespace weft::sim
