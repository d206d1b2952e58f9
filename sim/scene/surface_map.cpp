#include "sim/scene/surface_map.h"

#include <cassert>

namespace weft::sim {

SurfaceMap::SurfaceMap(std::vector<int> first_share, std::vector<Share> shares)
    : first_share_(std::move(first_share)), shares_(std::move(shares)) {
  assert(first_share_.size() > 1 && first_share_.front() == 0 &&
         first_share_.back() == static_cast<int>(shares_.size()));
}

// The sum starts with the first term instead of zero, so that a single weight of 1 gives exactly
// the particle's bits.
Eigen::Vector3d SurfaceMap::apply(int point, std::span<const Vec3> particles) const {
  const std::span<const Share> of_point = shares(point);
  Vec3 sum = of_point[0].weight * particles[of_point[0].particle];
  for (const auto& [particle, weight] : of_point.subspan(1)) sum += weight * particles[particle];
  return sum;
}

void SurfaceMap::apply(std::span<const Vec3> particles, std::span<Vec3> points, int first,
                       int last) const {
  for (int i = first; i < last; ++i) points[i] = apply(i, particles);
}

// The weight is multiplied by the factor first, so that a single weight of 1 gives exactly the bits
// of factor * value.
void SurfaceMap::add_transpose(int point, double factor, const Vec3& value,
                               std::span<Vec3> particles) const {
  for (const auto& [particle, weight] : shares(point))
    particles[particle] += weight * factor * value;
}

std::span<const Eigen::Vector3d> SurfaceMap::points_of(std::span<const Vec3> particles, int count,
                                                       std::vector<Vec3>& room) const {
  if (is_identity()) return particles.first(count);
  room.resize(count);
  apply(particles, room, 0, count);
  return room;
}

}  // namespace weft::sim
