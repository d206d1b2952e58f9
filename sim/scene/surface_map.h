// The sparse matrix S from particles to points of a surface: x_point = S x_particle.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace weft::sim {

// Points as weighted sums of particles. The velocities of points follow from those of particles in
// the same way. The transpose turns forces on points into forces on particles that do the same work
// in any motion. The weights of a point sum to 1: a rigid motion of the particles moves the points
// rigidly, and forces keep their resultant and their moment. Single weights may be negative.
class SurfaceMap {
 public:
  using Vec3 = Eigen::Vector3d;
  struct Share {
    int particle = 0;
    double weight = 0;
  };

  // The identity: point i is particle i. It stores nothing, not even the number of points.
  SurfaceMap() = default;
  // Point i has the shares from first_share[i] to first_share[i + 1] - 1: at least one, of
  // different particles.
  SurfaceMap(std::vector<int> first_share, std::vector<Share> shares);

  bool is_identity() const { return first_share_.empty(); }
  // Returns the first `count` points, m. For the identity the result is a view of `particles`, else
  // of `room`, which is filled.
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
  // Adds factor * value, a force on the point, to the particles by their weights.
  void add_transpose(int point, double factor, const Vec3& value, std::span<Vec3> particles) const;

 private:
  std::vector<int> first_share_;
  std::vector<Share> shares_;
};

}  // namespace weft::sim
