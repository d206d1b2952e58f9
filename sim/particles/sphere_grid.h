// A grid over spheres, which finds those that come near each other.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

// Pairs of spheres a < b, by the smaller index.
struct SpherePairs {
  std::vector<int> first;  // by sphere, and the number of pairs at the end
  std::vector<int> other;  // the larger index of each pair, ascending for each sphere

  std::span<const int> of(int sphere) const {
    return {other.data() + first[sphere], other.data() + first[sphere + 1]};
  }
  int count() const { return static_cast<int>(other.size()); }
};

// Cubic cells in a hash table, in layers: the cells of a layer are twice as wide as those of the
// layer below, and a sphere lies in the first layer whose cells are as wide as the sphere. A sphere
// therefore meets only those of 27 cells of each layer, whatever the ratio of the radii. The memory
// is kept between calls.
class SphereGrid {
 public:
  // Finds all pairs of spheres whose surfaces touch or overlap. `centres` (m) and `radii` (m, > 0)
  // have one entry per sphere and must be finite. Returns the number of pairs of spheres compared.
  // O(n) for spheres that are spread out.
  std::int64_t find_pairs(std::span<const Vec3> centres, std::span<const double> radii,
                          SpherePairs& pairs);

 private:
  using Cell = std::array<std::int32_t, 3>;
  struct Placed {
    Vec3 centre;
    double radius;
    Cell cell;
    std::int32_t layer;
    std::int32_t index;
  };
  struct Found {
    int a, b;
  };

  void place(std::span<const Vec3> centres, std::span<const double> radii);
  void compare_in_layer(const Placed& sphere, std::size_t slot);
  void compare_in_wider_layer(const Placed& sphere, int layer);
  void compare(const Placed& sphere, const Placed& other);
  void sort(int spheres, SpherePairs& pairs) const;
  std::uint32_t bucket_of(const Cell& cell, int layer) const;
  Cell cell_of(const Vec3& centre, int layer) const;

  double smallest_width_ = 0;  // m, of the cells of layer 0
  std::vector<int> in_layer_;  // number of spheres by layer
  std::uint32_t mask_ = 0;
  std::vector<std::uint32_t> start_;   // by bucket: the first place in placed_
  std::vector<std::uint32_t> bucket_;  // by sphere
  std::vector<Placed> unsorted_, placed_;
  std::vector<Found> found_;
  std::int64_t tests_ = 0;
};

}  // namespace weft::sim
