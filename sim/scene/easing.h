// An easing between two values: a polynomial whose first two derivatives are zero at both ends.
#pragma once

namespace weft::sim {

// The polynomial 6 s^5 - 15 s^4 + 10 s^3 for 0 <= s <= 1, and its first two derivatives.
inline double eased(double s) { return s * s * s * (10 + s * (6 * s - 15)); }
inline double eased_slope(double s) { return 30 * s * s * (1 - s) * (1 - s); }
inline double eased_curvature(double s) { return 60 * s * (1 - s) * (1 - 2 * s); }

}  // namespace weft::sim
