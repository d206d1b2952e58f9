// The bounding sphere image pyramid: a hierarchy of spheres over a geometry image, rebuilt from the
// deformed image in one O(n) pass.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// Texel of a level: centre and radius in float32. A negative radius marks a block without quads.
struct Sphere {
  float x = 0, y = 0, z = 0;
  float radius = -1;
};

enum class RadiusPolicy {
  exact,  // largest distance from the centre to any contained vertex (rounded up)
  fast,   // carried up from the children: max |c - c_i| + r_i, never more than the half diagonal
};

// Level l splits the quads of a patch into up to 2^l x 2^l nested blocks, each axis stopping at
// ceil(log2 of its quads); block boundaries are floor(k * quads / 2^l). The last level bounds one
// quad. A body of several patches has one more set of levels above the patch tops: see top().
//
// Conservative: every float64 vertex lies inside the float32 spheres of all the blocks that contain
// it, whatever the rounding.
class Pyramid {
 public:
  Pyramid() = default;
  explicit Pyramid(const Atlas& atlas, RadiusPolicy policy = RadiusPolicy::fast);

  // Rebuilds every level from the positions of the atlas' particles. O(quads). Returns the first
  // texel whose position is not finite (the pyramid is then not usable until the next rebuild).
  [[nodiscard]] std::optional<TexelAddress> rebuild(std::span<const Vec3> positions);
  // Bounds every vertex at both ends of its path, and so all along a straight one.
  [[nodiscard]] std::optional<TexelAddress> rebuild_swept(std::span<const Vec3> start,
                                                          std::span<const Vec3> end);
};

}  // namespace weft::bsi
