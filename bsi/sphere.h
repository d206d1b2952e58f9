// A sphere of the pyramid.
#pragma once

namespace weft::bsi {

// Centre and radius in float32, metres; a negative radius bounds nothing.
struct Sphere {
  float x = 0, y = 0, z = 0;
  float radius = -1;
  bool operator==(const Sphere&) const = default;
};

// A distance that no point of one sphere to a point of the other falls short of, whatever the
// rounding; 0 where they meet, infinity when one of them is empty. Metres.
double bounding_sphere_gap(const Sphere& first, const Sphere& second);

}  // namespace weft::bsi
