// Conservative continuous collision: may two features that move along straight lines come too
// close?
#pragma once

#include "bsi/proximity.h"

namespace weft::bsi {

// Largest fraction t in [0, 1] of the straight paths start -> end up to which the distance is
// certain to stay above `minimum_separation` (metres, >= 0); 1 when it does on the whole path.
// Never reports a safe path that is not (no false negatives); may stop early by
// `conservative_rescaling` of the starting distance. Points as in closest_vertex_triangle /
// closest_edge_edge. Additive CCD: Li, Kaufman, Jiang 2021, "Codimensional Incremental Potential
// Contact", section 5. Gives 0 when the start is already too close.
double safe_fraction_vertex_triangle(const FourPoints& start, const FourPoints& end,
                                     double minimum_separation);
double safe_fraction_edge_edge(const FourPoints& start, const FourPoints& end,
                               double minimum_separation);

}  // namespace weft::bsi
