// Spheres of the pyramid, and how tightly they bound.
#pragma once

namespace weft::bsi {

// Texel of a level: centre and radius in float32. A negative radius marks a block without quads.
struct Sphere {
  float x = 0, y = 0, z = 0;
  float radius = -1;
  bool operator==(const Sphere&) const = default;
};

// A distance that no point of one sphere to a point of the other falls short of, whatever the
// rounding; 0 where they meet, infinity when one of them is empty. Metres.
double bounding_sphere_gap(const Sphere& first, const Sphere& second);

// The centre is the middle of the box of the contained vertices, but for `tight`.
enum class RadiusPolicy {
  // Largest distance from the centre to any contained vertex, rounded up.
  exact,
  // Carried up from the children: max |c - c_i| + r_i, never more than the half diagonal of the
  // box; exact for a leaf.
  fast,
  // The smallest ball of the contained vertices (bsi/smallest_ball.h), rounded up; never larger
  // than `exact`. A hundred times the cost of that: for bodies at rest, built once.
  tight,
};

}  // namespace weft::bsi
