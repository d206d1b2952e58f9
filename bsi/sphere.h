// The bounding sphere of a block, as the pyramid stores it.
#pragma once

namespace weft::bsi {

// A sphere: centre and radius, m. It is empty if the radius is negative.
struct Sphere {
  float x = 0, y = 0, z = 0;
  float radius = -1;
  bool operator==(const Sphere&) const = default;
};

// Returns a lower bound (m) of the distance between two spheres. Rounding cannot make it exceed the
// distance. The result is 0 if the spheres meet, and infinity if either is empty.
double bounding_sphere_gap(const Sphere& first, const Sphere& second);

}  // namespace weft::bsi
