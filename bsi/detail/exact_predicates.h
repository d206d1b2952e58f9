// Orientation of points by the sign of a determinant, never wrong by rounding.
#pragma once

#include <array>

namespace weft::bsi {

using Point2 = std::array<double, 2>;
using Point3 = std::array<double, 3>;

// The sign (-1, 0, 1) of the exact determinant of rows a - c and b - c: 1 where a, b, c run
// counter-clockwise, 0 where they are on one line.
int orientation(const Point2& a, const Point2& b, const Point2& c);
// The sign of the exact determinant of rows a - d, b - d and c - d: 0 where the four are on one
// plane; a, b, c look counter-clockwise from d where it is -1.
int orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d);

// Both evaluate in doubles first and trust the sign beyond a bound of the error; else they sum the
// determinant without rounding, in expansions of doubles (Shewchuk 1997, "Adaptive Precision
// Floating-Point Arithmetic and Fast Robust Geometric Predicates"). Exact while no product of
// coordinates over- or underflows: coordinates and their differences are 0 or 1e-90..1e90 in size,
// as those of float32 numbers always are. About 10 ns, a microsecond or more where it is close.

}  // namespace weft::bsi
