// The surface that a [shape] table of a case describes.
#pragma once

#include "bsi/shapes.h"
#include "sim/case/case.h"

namespace weft::sim {

// Makes the shape around the origin, in m, or reads it if it comes from a file. Throws CaseError at
// the shape's place in the case.
bsi::Surface build_shape(const ShapeCase& shape, const Case& source);

}  // namespace weft::sim
