#include "sim/particles/enclosing_obstacles.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace weft::sim {

namespace {

// True if two triangles meet at every edge. Meshes of scenes with particles alone list no edges.
bool is_closed(const bsi::Mesh& mesh) {
  std::vector<std::pair<int, int>> sides;
  for (const auto& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) sides.push_back(std::minmax({triangle[k], triangle[(k + 1) % 3]}));
  }
  std::ranges::sort(sides);
  // An edge has two triangles at the most.
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    if (i + 1 == sides.size() || sides[i] != sides[i + 1]) return false;
  }
  return true;
}

// The surface of an obstacle above any point: its triangles in the squares of a grid, seen from
// above. Rays upwards are turned by a generic rotation, so that they are not parallel to the walls
// of boxes and cylinders.
class Canopy {
 public:
  Canopy(std::span<const Vec3> vertices, const bsi::Mesh& mesh) : mesh_(mesh) {
    for (const Vec3& vertex : vertices) {
      vertices_.push_back(turned(vertex));
      box_.extend(vertices_.back());
    }
    side_ = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(mesh.triangles.size()))));
    squares_.resize(static_cast<std::size_t>(side_) * side_);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      Eigen::AlignedBox3d box;
      for (const int corner : mesh.triangles[t]) box.extend(vertices_[corner]);
      const auto [first_x, first_y] = square_of(box.min());
      const auto [last_x, last_y] = square_of(box.max());
      for (int y = first_y; y <= last_y; ++y) {
        for (int x = first_x; x <= last_x; ++x)
          squares_[y * side_ + x].push_back(static_cast<int>(t));
      }
    }
  }

  // Returns how often the surface winds around a point: the sum of the orientations of the
  // triangles above it.
  int winding_number(const Vec3& place) const {
    const Vec3 point = turned(place);
    if (!box_.contains(point)) return 0;
    const auto [x, y] = square_of(point);
    int sum = 0;
    for (const int t : squares_[y * side_ + x]) sum += orientation_above(mesh_.triangles[t], point);
    return sum;
  }

 private:
  static Vec3 turned(const Vec3& x) {
    static const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(1.234567, Vec3(0.48, 0.6, 0.64)).toRotationMatrix();
    return rotation * x;
  }

  std::array<int, 2> square_of(const Vec3& point) const {
    std::array<int, 2> square{};
    for (int k = 0; k < 2; ++k) {
      const double share = (point[k] - box_.min()[k]) / box_.sizes()[k];
      square[k] = std::clamp(static_cast<int>(share * side_), 0, side_ - 1);
    }
    return square;
  }

  // Returns the part that the edge a -> b has in the winding number of a triangle around a point in
  // the plane: 1 or -1 if it crosses the ray from the point along +x upwards or downwards, else 0
  // (D. Sunday, "Inclusion of a point in a polygon", 2001). Edges that two triangles share cancel
  // exactly, because the smaller vertex comes first in the arithmetic.
  int crossing(int a, int b, const Vec3& point) const {
    if (a > b) return -crossing(b, a, point);
    const Vec3 &from = vertices_[a], &to = vertices_[b];
    const bool is_upward = from.y() <= point.y() && point.y() < to.y(),
               is_downward = to.y() <= point.y() && point.y() < from.y();
    if (!is_upward && !is_downward) return 0;
    const double side =
        (to.x() - from.x()) * (point.y() - from.y()) - (to.y() - from.y()) * (point.x() - from.x());
    if (is_upward) return side > 0 ? 1 : 0;
    return side < 0 ? -1 : 0;
  }

  int orientation_above(const std::array<int, 3>& triangle, const Vec3& point) const {
    const auto& [a, b, c] = triangle;
    const int orientation = crossing(a, b, point) + crossing(b, c, point) + crossing(c, a, point);
    if (orientation == 0) return 0;
    const Vec3 normal = (vertices_[b] - vertices_[a]).cross(vertices_[c] - vertices_[a]);
    const bool is_above = (vertices_[a] - point).dot(normal) * orientation > 0;
    return is_above ? orientation : 0;
  }

  const bsi::Mesh& mesh_;
  std::vector<Vec3> vertices_;  // m, turned
  Eigen::AlignedBox3d box_;
  int side_ = 1;                           // squares along each axis
  std::vector<std::vector<int>> squares_;  // triangles by square, row by row
};

}  // namespace

std::vector<EnclosedSpheres> enclosed_spheres(const Scene& scene) {
  std::vector<EnclosedSpheres> result;
  if (scene.source.particles.empty()) return result;
  const auto places = [&](const SceneBody& body) {
    return std::span<const Vec3>(scene.initial_position)
        .subspan(body.first_particle, body.particle_count());
  };
  const int count = static_cast<int>(scene.bodies.size());
  for (int o = scene.dynamic_bodies; o < count; ++o) {
    const SceneBody& obstacle = scene.bodies[o];
    if (!is_closed(obstacle.mesh)) continue;
    const Canopy canopy(places(obstacle), obstacle.mesh);
    for (int g = 0; g < scene.dynamic_bodies; ++g) {
      if (scene.bodies[g].spheres == nullptr || scene.bodies[g].are_spins) continue;
      const auto inside = std::ranges::count_if(places(scene.bodies[g]), [&](const Vec3& centre) {
        return canopy.winding_number(centre) != 0;
      });
      if (inside > 0) result.push_back({g, o, static_cast<int>(inside)});
    }
  }
  return result;
}

}  // namespace weft::sim
