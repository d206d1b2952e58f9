#include "sim/particles/sphere_grid.h"

#include <Eigen/Geometry>
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
// Spheres whose distances are computed before the near ones among them are noted.
constexpr std::size_t chunk = 64;

}  // namespace

SphereGrid::Cell SphereGrid::cell_of(const Vec3& centre, int layer) const {
  Cell cell;
  for (int k = 0; k < 3; ++k)
    cell[k] = static_cast<std::int32_t>(
        std::clamp(std::floor(cells_per_metre_[layer] * centre[k]), -last_cell, last_cell));
  return cell;
}

// Cells that are near each other lie in buckets that are near each other, so that a sweep over the
// buckets finds most neighbours in the processor's caches. Those along x follow each other.
std::uint32_t SphereGrid::bucket_of(const Cell& cell, int layer) const {
  return (static_cast<std::uint32_t>(cell[0]) + row_ * static_cast<std::uint32_t>(cell[1]) +
          plane_ * static_cast<std::uint32_t>(cell[2]) +
          83492791u * static_cast<std::uint32_t>(layer)) &
         mask_;
}

// Chooses the widths of the cells, and the order of the buckets.
void SphereGrid::lay_out(std::span<const Vec3> centres, std::span<const double> radii) {
  const double smallest = 2 * *std::ranges::min_element(radii);
  assert(smallest > 0);
  width_.resize(last_layer + 1);
  cells_per_metre_.resize(last_layer + 1);
  for (int layer = 0; layer <= last_layer; ++layer) {
    width_[layer] = std::ldexp(smallest, layer);
    cells_per_metre_[layer] = std::ldexp(1 / smallest, -layer);
  }
  Eigen::AlignedBox3d box;
  for (const Vec3& centre : centres) box.extend(centre);
  const Cell low = cell_of(box.min(), 0), high = cell_of(box.max(), 0);
  // Odd numbers spread the cells of a box that has more cells than there are buckets.
  row_ = static_cast<std::uint32_t>(high[0] - low[0] + 2) | 1;
  plane_ = row_ * (static_cast<std::uint32_t>(high[1] - low[1] + 2) | 1);
  mask_ = static_cast<std::uint32_t>(std::bit_ceil(2 * centres.size())) - 1;
}

// Sorts the spheres by their buckets.
void SphereGrid::place(std::span<const Vec3> centres, std::span<const double> radii) {
  const std::size_t count = centres.size();
  start_.assign(mask_ + 2, 0);
  where_.resize(count);
  in_layer_.assign(last_layer + 1, 0);
  top_layer_ = 0;
  for (std::size_t i = 0; i < count; ++i) {
    int layer = 0;
    while (layer < last_layer && width_[layer] < 2 * radii[i]) ++layer;
    ++in_layer_[layer];
    top_layer_ = std::max(top_layer_, layer);
    const Cell cell = cell_of(centres[i], layer);
    where_[i] = {cell, layer, bucket_of(cell, layer)};
    ++start_[where_[i].bucket + 1];
  }
  for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
  x_.resize(count);
  y_.resize(count);
  z_.resize(count);
  radius_.resize(count);
  sphere_.resize(count);
  // Filling from the end leaves the starts of the buckets behind.
  for (std::size_t i = count; i-- > 0;) {
    const std::uint32_t slot = --start_[where_[i].bucket + 1];
    x_[slot] = centres[i].x();
    y_[slot] = centres[i].y();
    z_[slot] = centres[i].z();
    radius_[slot] = radii[i];
    sphere_[slot] = static_cast<int>(i);
  }
  std::copy(start_.begin() + 1, start_.end(), start_.begin());
  start_.back() = static_cast<std::uint32_t>(count);
}

// Notes those of the spheres in slots first to end - 1 that touch the sphere in a slot. Cells that
// share a bucket need no test of their own: what touches is a pair wherever it was found.
void SphereGrid::compare(std::size_t slot, std::size_t first, std::size_t end) {
  tests_ += static_cast<std::int64_t>(end - first);
  const double x = x_[slot], y = y_[slot], z = z_[slot], radius = radius_[slot];
  const int sphere = sphere_[slot];
  for (; first < end; first += chunk) {
    const std::size_t count = std::min(chunk, end - first);
    std::array<double, chunk> depth;
    for (std::size_t i = 0; i < count; ++i) {
      const double dx = x - x_[first + i], dy = y - y_[first + i], dz = z - z_[first + i],
                   reach = radius + radius_[first + i];
      depth[i] = reach * reach - (dx * dx + dy * dy + dz * dz);
    }
    std::array<Found, chunk> found;
    std::size_t touching = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const int other = sphere_[first + i];
      found[touching] = {std::min(sphere, other), std::max(sphere, other)};
      touching += depth[i] >= 0 && other != sphere ? 1 : 0;
    }
    found_.insert(found_.end(), found.begin(), found.begin() + touching);
  }
}

// Compares the sphere in a slot with those of three cells along x, of which it gets the middle one.
void SphereGrid::compare_row(std::size_t slot, const Cell& middle, int layer) {
  const std::uint32_t first = bucket_of({middle[0] - 1, middle[1], middle[2]}, layer);
  if (first + 2 <= mask_) return compare(slot, start_[first], start_[first + 3]);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const std::uint32_t bucket = (first + i) & mask_;
    compare(slot, start_[bucket], start_[bucket + 1]);
  }
}

// Compares a sphere with those of its own bucket that follow, and with those of 13 cells around it.
void SphereGrid::compare_in_layer(std::size_t slot) {
  constexpr std::array<std::array<int, 2>, 4> rows{{{1, 0}, {-1, 1}, {0, 1}, {1, 1}}};
  const Where& where = where_[sphere_[slot]];
  const auto [x, y, z] = where.cell;
  compare(slot, slot + 1, start_[where.bucket + 1]);
  const std::uint32_t next = (where.bucket + 1) & mask_;
  compare(slot, start_[next], start_[next + 1]);
  for (const auto& [dy, dz] : rows) compare_row(slot, {x, y + dy, z + dz}, where.layer);
}

void SphereGrid::compare_in_wider_layer(std::size_t slot, int layer) {
  const auto [x, y, z] = cell_of({x_[slot], y_[slot], z_[slot]}, layer);
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) compare_row(slot, {x, y + dy, z + dz}, layer);
  }
}

// Sorts the pairs by counting, then the few pairs of each sphere. Cells that share a bucket may
// have found a pair twice.
void SphereGrid::sort(int spheres, SpherePairs& pairs) const {
  pairs.first.assign(static_cast<std::size_t>(spheres) + 2, 0);
  pairs.other.resize(found_.size());
  for (const Found& pair : found_) ++pairs.first[pair.a + 2];
  for (std::size_t i = 2; i < pairs.first.size(); ++i) pairs.first[i] += pairs.first[i - 1];
  for (const Found& pair : found_) pairs.other[pairs.first[pair.a + 1]++] = pair.b;
  pairs.first.pop_back();
  auto kept = pairs.other.begin();
  for (int i = 0, first = 0; i < spheres; ++i) {
    const auto begin = pairs.other.begin() + first, end = pairs.other.begin() + pairs.first[i + 1];
    first = pairs.first[i + 1];
    std::sort(begin, end);
    pairs.first[i] = static_cast<int>(kept - pairs.other.begin());
    kept = std::unique_copy(begin, end, kept);
  }
  pairs.first.back() = static_cast<int>(kept - pairs.other.begin());
  pairs.other.erase(kept, pairs.other.end());
}

std::int64_t SphereGrid::find_pairs(std::span<const Vec3> centres, std::span<const double> radii,
                                    SpherePairs& pairs) {
  assert(centres.size() == radii.size());
  found_.clear();
  tests_ = 0;
  if (!centres.empty()) {
    lay_out(centres, radii);
    place(centres, radii);
    for (std::size_t slot = 0; slot < centres.size(); ++slot) {
      compare_in_layer(slot);
      for (int layer = where_[sphere_[slot]].layer + 1; layer <= top_layer_; ++layer) {
        if (in_layer_[layer] > 0) compare_in_wider_layer(slot, layer);
      }
    }
  }
  sort(static_cast<int>(centres.size()), pairs);
  return tests_;
}

}  // namespace weft::sim
