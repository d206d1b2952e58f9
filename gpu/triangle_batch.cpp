#include "gpu/triangle_batch.h"

#include <Eigen/Geometry>
#include <cassert>

namespace weft::gpu {
namespace {

std::array<float, 3> single(const Vec3& vector) {
  return {static_cast<float>(vector.x()), static_cast<float>(vector.y()),
          static_cast<float>(vector.z())};
}

}  // namespace

std::vector<Vec3> vertex_normals(const DrawnSurface& surface) {
  std::vector<Vec3> normals(surface.positions.size(), Vec3::Zero());
  for (const auto& [a, b, c] : surface.triangles) {
    assert(std::max({a, b, c}) < static_cast<int>(normals.size()) && std::min({a, b, c}) >= 0);
    const Vec3& corner = surface.positions[a];
    const Vec3 area = (surface.positions[b] - corner).cross(surface.positions[c] - corner);
    for (const int vertex : {a, b, c}) normals[vertex] += area;
  }
  for (Vec3& normal : normals) normal.stableNormalize();
  return normals;
}

std::vector<Vec3> detail_normals(const bsi::DetailSurface& detail, const DrawnSurface& original) {
  const std::vector<Vec3> normals = vertex_normals(original);
  std::vector<Vec3> taken;
  taken.reserve(detail.particles.size());
  for (const int particle : detail.particles) taken.push_back(normals[particle]);
  return taken;
}

void TriangleBatch::assemble(std::span<const DrawnSurface> surfaces, const Vec3& origin) {
  vertices_.clear();
  indices_.clear();
  ranges_.assign(surfaces.size(), {});
  std::vector<std::uint32_t> first_vertex;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const DrawnSurface& surface = surfaces[i];
    first_vertex.push_back(static_cast<std::uint32_t>(vertices_.size()));
    const std::vector<Vec3> computed =
        surface.normals.empty() ? vertex_normals(surface) : std::vector<Vec3>();
    const std::span<const Vec3> normals = surface.normals.empty() ? computed : surface.normals;
    assert(normals.size() == surface.positions.size());
    for (std::size_t vertex = 0; vertex < normals.size(); ++vertex) {
      vertices_.push_back({single(surface.positions[vertex] - origin), single(normals[vertex])});
    }
    ranges_[i].first_triangle_index = static_cast<int>(indices_.size());
    for (const std::array<int, 3>& triangle : surface.triangles) {
      for (const int vertex : triangle) indices_.push_back(first_vertex[i] + vertex);
    }
    ranges_[i].triangle_indices =
        static_cast<int>(indices_.size()) - ranges_[i].first_triangle_index;
  }
  triangle_index_count_ = static_cast<int>(indices_.size());
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    for (const std::array<int, 2>& line : surfaces[i].lines) {
      for (const int vertex : line) indices_.push_back(first_vertex[i] + vertex);
    }
  }
}

}  // namespace weft::gpu
