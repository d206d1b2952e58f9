// A bounding hierarchy over many separate spheres, which finds those that come near each other.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "bsi/leaf_pair.h"

namespace weft::bsi {

// A pyramid of boxes over spheres that are sorted along a Morton curve. A leaf block holds up to
// `leaf_size` consecutive spheres, and every block above joins up to four consecutive blocks. The
// boxes bound whole spheres in double precision. Pairs whose distance differs from the margin by
// rounding errors of the coordinates may be found or not.
class SphereHierarchy {
 public:
  // Builds the hierarchy anew. `centres` (m) and `radii` (m, >= 0) have one entry per sphere and
  // must be finite. The spheres are sorted anew at every call, so that the result depends on them
  // alone. O(n log n).
  void rebuild(std::span<const Vec3> centres, std::span<const double> radii);

  // Returns all pairs of spheres whose surfaces are within `margin` (m, >= 0), with a < b, in
  // ascending order. O(n + pairs log pairs) for spheres that are spread out. `tests` is increased
  // by the number of boxes and spheres that are compared.
  std::vector<LeafPair> near_pairs(double margin, std::int64_t& tests) const;

 private:
  static constexpr int leaf_size = 8, children = 4;
  struct Block {
    Vec3 low{0, 0, 0}, high{0, 0, 0};
  };
  struct Placed {
    Vec3 centre{0, 0, 0};
    double radius = 0;
    int index = 0;
  };
  class Traversal;

  void sort(std::span<const Vec3> centres, std::span<const double> radii);
  void bound();

  std::vector<Placed> spheres_;             // along the curve
  std::vector<std::vector<Block>> levels_;  // from the leaf blocks up to a single block
};

}  // namespace weft::bsi
