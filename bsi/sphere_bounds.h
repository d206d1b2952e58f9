// Rounding: how float32 bounds of float64 vertices stay bounds. For pyramid.cpp and block_row.cpp.
#pragma once

#include <cmath>

namespace weft::bsi {

// Rounding bounds, with u = 2^-24 the unit roundoff of float32. A length computed as sqrt(dx^2 +
// dy^2 + dz^2) from float32 differences falls short by at most 3.5 u of itself; adding a radius and
// multiplying make it 5.5 u (standard model, Higham 2002, section 2.2), less than round_up adds.
inline constexpr float round_up = 1 + 0x1p-21F;
// Rounding a vertex to float32 moves it by at most sqrt(3) u of its largest coordinate.
inline constexpr float vertex_rounding = 0x1p-23F;
// Added to every radius: far below anything physical, and above all that underflow can lose (the
// square of a length under 1e-22 m, or one flushed to zero under 1e-19 m).
inline constexpr float radius_floor = 1e-18F;

// By value: g++ 12 does not vectorise the std ones, which return references.
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }

inline float square(float x, float y, float z) { return x * x + y * y + z * z; }

// One axis of a box of float32 vertices.
struct Interval {
  float low;
  float high;
  float middle() const { return 0.5F * (low + high); }
  // Of the middle, which is rounded.
  float half() const { return larger(high - middle(), middle() - low); }
  float magnitude() const { return larger(std::fabs(low), std::fabs(high)); }
};

inline Interval join(Interval a, Interval b) {
  return {smaller(a.low, b.low), larger(a.high, b.high)};
}

inline float half_diagonal(Interval x, Interval y, Interval z) {
  return std::sqrt(square(x.half(), y.half(), z.half()));
}

// The largest magnitude of a coordinate.
inline float magnitude(Interval x, Interval y, Interval z) {
  return larger(x.magnitude(), larger(y.magnitude(), z.magnitude()));
}

// Radius that covers float64 vertices, given how far their float32 roundings reach.
inline float cover(float reach, float largest_coordinate) {
  return reach * round_up + (largest_coordinate * vertex_rounding + radius_floor);
}

// The same, given how far the spheres of the children reach, which cover float64 vertices already.
inline float carry(float reach) { return reach * round_up + radius_floor; }

}  // namespace weft::bsi
