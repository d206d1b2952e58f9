// The surface that a [shape] table of a case describes.
#pragma once

#include "bsi/shapes.h"
#include "sim/case/case.h"

namespace weft::sim {

// Returns the surface of a shape in its own frame, m. A shape from a file is read, others are made
// around the origin. Throws CaseError at the shape's place in the case.
bsi::Surface build_shape(const ShapeCase& shape, const Case& source);

}  // namespace weft::sim
