#include "sim/particles/sphere_grid.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace weft::sim {

namespace {

// Largest number of a cell. Spheres beyond share the outermost cells, and stay neighbours there.
constexpr double last_cell = 1 << 29;
// Widest cells, as a power of two of the narrowest.
constexpr int last_layer = 60;

// Comparison by numbers, which is faster than that of std::array.
bool is_same(const std::array<std::int32_t, 3>& a, const std::array<std::int32_t, 3>& b) {
  return ((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) == 0;
}

}  // namespace

SphereGrid::Cell SphereGrid::cell_of(const Vec3& centre, int layer) const {
  const double scale = std::ldexp(1 / smallest_width_, -layer);
  Cell cell;
  for (int k = 0; k < 3; ++k)
    cell[k] =
        static_cast<std::int32_t>(std::clamp(std::floor(scale * centre[k]), -last_cell, last_cell));
  return cell;
}

// Cells that follow each other along x lie in buckets that follow each other.
std::uint32_t SphereGrid::bucket_of(const Cell& cell, int layer) const {
  return (static_cast<std::uint32_t>(cell[0]) + 73856093u * static_cast<std::uint32_t>(cell[1]) +
          19349669u * static_cast<std::uint32_t>(cell[2]) +
          83492791u * static_cast<std::uint32_t>(layer)) &
         mask_;
}

// Sorts the spheres by their buckets.
void SphereGrid::place(std::span<const Vec3> centres, std::span<const double> radii) {
  const std::size_t count = centres.size();
  smallest_width_ = 2 * *std::ranges::min_element(radii);
  assert(smallest_width_ > 0);
  mask_ = static_cast<std::uint32_t>(std::bit_ceil(2 * count)) - 1;
  start_.assign(mask_ + 2, 0);
  bucket_.resize(count);
  unsorted_.resize(count);
  in_layer_.assign(last_layer + 1, 0);
  for (std::size_t i = 0; i < count; ++i) {
    int layer = 0;
    while (layer < last_layer && std::ldexp(smallest_width_, layer) < 2 * radii[i]) ++layer;
    ++in_layer_[layer];
    const Cell cell = cell_of(centres[i], layer);
    unsorted_[i] = {centres[i], radii[i], cell, layer, static_cast<std::int32_t>(i)};
    bucket_[i] = bucket_of(cell, layer);
    ++start_[bucket_[i] + 1];
  }
  for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
  placed_.resize(count);
  // Filling from the end leaves the starts of the buckets behind.
  for (std::size_t i = count; i-- > 0;) placed_[--start_[bucket_[i] + 1]] = unsorted_[i];
  std::copy(start_.begin() + 1, start_.end(), start_.begin());
  start_.back() = static_cast<std::uint32_t>(count);
}

void SphereGrid::compare(const Placed& sphere, const Placed& other) {
  ++tests_;
  const double reach = sphere.radius + other.radius;
  if ((sphere.centre - other.centre).squaredNorm() > reach * reach) return;
  found_.push_back({std::min(sphere.index, other.index), std::max(sphere.index, other.index)});
}

// Compares a sphere with those of its own cell that follow, and with those of 13 cells around it.
void SphereGrid::compare_in_layer(const Placed& sphere, std::size_t slot) {
  constexpr std::array<std::array<int, 2>, 4> rows{{{1, 0}, {-1, 1}, {0, 1}, {1, 1}}};
  const auto [x, y, z] = sphere.cell;
  const std::uint32_t own = bucket_of(sphere.cell, sphere.layer);
  for (std::size_t k = slot + 1; k < start_[own + 1]; ++k) {
    if (is_same(placed_[k].cell, sphere.cell) && placed_[k].layer == sphere.layer)
      compare(sphere, placed_[k]);
  }
  const auto scan = [&](const Cell& cell) {
    const std::uint32_t bucket = bucket_of(cell, sphere.layer);
    for (std::size_t k = start_[bucket]; k < start_[bucket + 1]; ++k) {
      if (is_same(placed_[k].cell, cell) && placed_[k].layer == sphere.layer)
        compare(sphere, placed_[k]);
    }
  };
  scan({x + 1, y, z});
  for (const auto& [dy, dz] : rows) {
    for (int dx = -1; dx <= 1; ++dx) scan({x + dx, y + dy, z + dz});
  }
}

void SphereGrid::compare_in_wider_layer(const Placed& sphere, int layer) {
  const auto [x, y, z] = cell_of(sphere.centre, layer);
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell cell{x + dx, y + dy, z + dz};
        const std::uint32_t bucket = bucket_of(cell, layer);
        for (std::size_t k = start_[bucket]; k < start_[bucket + 1]; ++k) {
          if (is_same(placed_[k].cell, cell) && placed_[k].layer == layer)
            compare(sphere, placed_[k]);
        }
      }
    }
  }
}

// Sorts the pairs by counting, then the few pairs of each sphere.
void SphereGrid::sort(int spheres, SpherePairs& pairs) const {
  pairs.first.assign(static_cast<std::size_t>(spheres) + 2, 0);
  pairs.other.resize(found_.size());
  for (const Found& pair : found_) ++pairs.first[pair.a + 2];
  for (std::size_t i = 2; i < pairs.first.size(); ++i) pairs.first[i] += pairs.first[i - 1];
  for (const Found& pair : found_) pairs.other[pairs.first[pair.a + 1]++] = pair.b;
  pairs.first.pop_back();
  for (int i = 0; i < spheres; ++i)
    std::sort(pairs.other.begin() + pairs.first[i], pairs.other.begin() + pairs.first[i + 1]);
}

std::int64_t SphereGrid::find_pairs(std::span<const Vec3> centres, std::span<const double> radii,
                                    SpherePairs& pairs) {
  assert(centres.size() == radii.size());
  found_.clear();
  tests_ = 0;
  if (!centres.empty()) {
    place(centres, radii);
    for (std::size_t slot = 0; slot < placed_.size(); ++slot) {
      const Placed& sphere = placed_[slot];
      compare_in_layer(sphere, slot);
      for (int layer = sphere.layer + 1; layer <= last_layer; ++layer) {
        if (in_layer_[layer] > 0) compare_in_wider_layer(sphere, layer);
      }
    }
  }
  sort(static_cast<int>(centres.size()), pairs);
  return tests_;
}

}  // namespace weft::sim
