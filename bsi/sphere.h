// A sphere of the pyramid.
#pragma once

namespace weft::bsi {

// Centre and radius in float32, m. A negative radius bounds nothing.
struct Sphere {
  float x = 0, y = 0, z = 0;
  float radius = -1;
  bool operator==(const Sphere&) const = default;
};

// Returns a lower bound (m) of the distance from any point of one sphere to any point of the other,
// whatever the rounding. 0 if they meet, infinity if one of them is empty.
double bounding_sphere_gap(const Sphere& first, const Sphere& second);

}  // namespace weft::bsi
