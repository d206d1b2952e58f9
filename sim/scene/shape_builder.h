// The surface that a [shape] table of a case describes.
#pragma once

#include "bsi/shapes.h"
#include "sim/case/case.h"

namespace weft::sim {

// Makes the shape around the origin, m; a shape from a file is read. Throws CaseError at the
// shape's place.
bsi::Surface build_shape(const ShapeCase& shape, const Case& source);

}  // namespace weft::sim
