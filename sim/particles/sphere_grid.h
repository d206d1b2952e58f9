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
  struct Where {
    Cell cell;
    std::int32_t layer;
    std::uint32_t bucket;
  };
  struct Found {
    int a, b;
  };

  void lay_out(std::span<const Vec3> centres, std::span<const double> radii);
  void place(std::span<const Vec3> centres, std::span<const double> radii);
  void compare(std::size_t slot, std::size_t first, std::size_t end);
  void compare_row(std::size_t slot, const Cell& middle, int layer);
  void compare_in_layer(std::size_t slot);
  void compare_in_wider_layer(std::size_t slot, int layer);
  void sort(int spheres, SpherePairs& pairs) const;
  std::uint32_t bucket_of(const Cell& cell, int layer) const;
  Cell cell_of(const Vec3& centre, int layer) const;

  // By layer: width of the cells (m), its inverse, and number of spheres. top_layer_ is the last
  // one with spheres.
  std::vector<double> width_, cells_per_metre_;
  std::vector<int> in_layer_;
  int top_layer_ = 0;
  std::uint32_t mask_ = 0;
  // Buckets from a cell to its neighbours along y and along z.
  std::uint32_t row_ = 1, plane_ = 1;
  std::vector<std::uint32_t> start_;  // by bucket: its first slot; then the number of slots
  std::vector<Where> where_;          // by sphere
  // By slot: the spheres in the order of their buckets.
  std::vector<double> x_, y_, z_, radius_;  // m
  std::vector<int> sphere_;
  std::vector<Found> found_;
  std::int64_t tests_ = 0;
};

}  // namespace weft::sim
