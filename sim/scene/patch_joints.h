// Borders that patches of a spline surface share.
#pragma once

#include <vector>

#include "bsi/geometry_image.h"

namespace weft::sim {

// A border that two patches have in common as a whole. Their surfaces meet in the spline curve with
// the control points `border`. `first` and `second` are the control points beside the border in
// either patch, in the same order. All are local indices.
struct PatchJoint {
  std::vector<int> border, first, second;
  bool is_closed = false;  // the border is a closed curve
};

// Returns the joints between the patches of an atlas, in the order of the first patch and its
// borders. Throws std::invalid_argument, naming the patch, if patches have only a part of a border
// in common, because their splines would not meet there. Precondition: bsi::build_mesh() accepts
// the atlas, and each axis has at least three control points. O(border texels log border texels).
std::vector<PatchJoint> find_patch_joints(const bsi::Atlas& atlas);

}  // namespace weft::sim
