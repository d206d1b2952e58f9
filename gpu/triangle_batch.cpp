#include "gpu/triangle_batch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>

namespace weft::gpu {
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
  vertices.clear();
  places.clear();
  triangles.clear();
  lines.clear();
  const bool has_places = std::ranges::any_of(
      surfaces, [](const DrawnSurface& surface) { return surface.colour_map != nullptr; });
  for (std::uint32_t number = 0; number < surfaces.size(); ++number) {
    const DrawnSurface& surface = surfaces[number];
    const auto first = static_cast<std::uint32_t>(vertices.size());
    const std::vector<Vec3> computed =
        surface.normals.empty() ? vertex_normals(surface) : std::vector<Vec3>();
    const std::span<const Vec3> normals = surface.normals.empty() ? computed : surface.normals;
    assert(normals.size() == surface.positions.size());
    for (std::size_t i = 0; i < normals.size(); ++i) {
      BatchVertex& vertex = vertices.emplace_back();
      vertex.values << (surface.positions[i] - origin).cast<float>().array(),
          normals[i].cast<float>().array(), 0, 0;
    }
    if (surface.colour_map != nullptr) {
      assert(surface.places.size() == surface.positions.size());
      places.insert(places.end(), surface.places.begin(), surface.places.end());
    } else if (has_places) {
      places.resize(vertices.size());
    }
    for (const auto& [a, b, c] : surface.triangles) {
      triangles.push_back({{first + a, first + b, first + c}, number});
    }
    for (const auto& [from, to] : surface.lines) lines.push_back({first + from, first + to});
  }
}

}  // namespace weft::gpu
