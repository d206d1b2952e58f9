// An oracle for continuous collision: decides without rounding whether two features meet.
#pragma once

#include "bsi/detail/feature_batches.h"
#include "bsi/proximity.h"

namespace weft::bsi {

// Returns true if the features of `kind` have a common point at some time in [0, until] on the
// straight paths start + t (end - start). Points are ordered as in closest_vertex_triangle() and
// closest_edge_edge(). Features without area or length are the segments or points that they span.
//
// The coordinates are integers times a power of two. The features meet where polynomials in t, of
// degree 4 at most, are zero or not negative. Their signs at the roots of each other are found with
// integers of any length, by Sturm's theorem. Takes some microseconds where the four points are in
// one plane at no time, and up to a millisecond otherwise. Precondition: finite points, 0 <= until.
bool features_meet(FeatureKind kind, const FourPoints& start, const FourPoints& end,
                   double until = 1);

}  // namespace weft::bsi
