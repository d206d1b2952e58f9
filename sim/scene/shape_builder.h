// The surface that a [shape] table of a case describes.
#pragma once

#include "bsi/shapes.h"
#include "sim/case/case.h"

namespace weft::sim {

// Returns the surface of a shape in its own frame, m. The surface is read from a file or made
// around the origin. Throws CaseError at the place of the shape in the case.
bsi::Surface build_shape(const ShapeCase& shape, const Case& source);

}  // namespace weft::sim
