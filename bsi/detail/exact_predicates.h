// Orientation of points: the exact sign of a determinant, which rounding cannot change.
#pragma once

#include <array>

namespace weft::bsi {

using Point2 = std::array<double, 2>;
using Point3 = std::array<double, 3>;

// Returns the sign (-1, 0, 1) of the exact determinant of the rows a - c and b - c. It is 1 if a,
// b, c are in counter-clockwise order, and 0 if they are on one line.
int orientation(const Point2& a, const Point2& b, const Point2& c);
// Returns the sign (-1, 0, 1) of the exact determinant of the rows a - d, b - d and c - d. It is 0
// if the four points are on one plane, and -1 if a, b, c are counter-clockwise seen from d.
int orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d);

// Both orientation() functions evaluate the determinant in float64 first and trust its sign if its
// magnitude exceeds an error bound, or if that bound is 0. Otherwise they sum the determinant
// without rounding, in expansions of doubles (Shewchuk 1997, "Adaptive Precision Floating-Point
// Arithmetic and Fast Robust Geometric Predicates"). The result is exact if no product of
// coordinates overflows or underflows. This holds if coordinates and their differences are 0 or
// 1e-90..1e90 in size, as for all float32 numbers. Takes about 10 ns, or a microsecond and more
// near zero.

}  // namespace weft::bsi
