// The sparse matrix S from particles to points of a surface: x_point = S x_particle.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace weft::sim {

// Points as weighted sums of particles. The same weights give velocities of points from velocities
// of particles. The transpose turns forces on points into forces on particles that do the same work
// in any motion. The weights of a point sum to 1. A rigid motion of the particles therefore moves
// the points rigidly, and forces keep their resultant and their moment. Single weights may be
// negative.
class SurfaceMap {
 public:
  using Vec3 = Eigen::Vector3d;
  struct Share {
    int particle = 0;
    double weight = 0;
  };

  // The identity map: point i is particle i. It stores nothing, not even the number of points.
  SurfaceMap() = default;
  // Point i has the shares first_share[i] .. first_share[i + 1] - 1: at least one, all of different
  // particles.
  SurfaceMap(std::vector<int> first_share, std::vector<Share> shares);

  bool is_identity() const { return first_share_.empty(); }
  // Returns the first `count` points, m. For the identity, the result is a view of `particles`.
  // Otherwise it is a view of `room`, which receives the points.
  std::span<const Vec3> points_of(std::span<const Vec3> particles, int count,
                                  std::vector<Vec3>& room) const;
  // Precondition of all functions below: not the identity.
  int point_count() const { return static_cast<int>(first_share_.size()) - 1; }
  std::span<const Share> shares(int point) const {
    return {shares_.data() + first_share_[point], shares_.data() + first_share_[point + 1]};
  }
  Vec3 apply(int point, std::span<const Vec3> particles) const;
  // Sets points[i] to apply(i, particles) for first <= i < last.
  void apply(std::span<const Vec3> particles, std::span<Vec3> points, int first, int last) const;
  // Adds `factor` times `value`, a force on the point, to the forces on the particles by their
  // weights.
  void add_transpose(int point, double factor, const Vec3& value, std::span<Vec3> particles) const;

 private:
  std::vector<int> first_share_;
  std::vector<Share> shares_;
};

}  // namespace weft::sim
