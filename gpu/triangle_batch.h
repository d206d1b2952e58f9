// The surfaces of one picture as one array of vertices and one of indices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/renderer.h"

namespace weft::gpu {

struct BatchVertex {
  std::array<float, 3> position;  // m, relative to an origin near what is looked at
  std::array<float, 3> normal;    // unit, or zero where the surface has no area
};

// The indices of one surface.
struct BatchRange {
  int first_triangle_index = 0, triangle_indices = 0;
};

class TriangleBatch {
 public:
  // O(vertices + triangles). Triangles of all surfaces come first, then the lines.
  void assemble(std::span<const DrawnSurface> surfaces, const Vec3& origin);

  const std::vector<BatchVertex>& vertices() const { return vertices_; }
  const std::vector<std::uint32_t>& indices() const { return indices_; }
  std::ptrdiff_t vertex_bytes() const {
    return static_cast<std::ptrdiff_t>(vertices_.size() * sizeof(BatchVertex));
  }
  std::ptrdiff_t index_bytes() const {
    return static_cast<std::ptrdiff_t>(indices_.size() * sizeof(std::uint32_t));
  }
  int triangle_index_count() const { return triangle_index_count_; }
  int line_index_count() const { return static_cast<int>(indices_.size()) - triangle_index_count_; }
  const BatchRange& range(std::size_t surface) const { return ranges_[surface]; }

 private:
  std::vector<BatchVertex> vertices_;
  std::vector<std::uint32_t> indices_;
  std::vector<BatchRange> ranges_;
  int triangle_index_count_ = 0;
};

// Unit normals by vertex: the sum of the areas of the triangles around it, as vectors, made unit.
// Zero where that sum is zero.
std::vector<Vec3> vertex_normals(const DrawnSurface& surface);
// Returns the normals of the original surface at the places of the detail's vertices, so that the
// light falls on a surface of reduced detail as on the original. O(triangles of the original).
std::vector<Vec3> detail_normals(const bsi::DetailSurface& detail, const DrawnSurface& original);

}  // namespace weft::gpu
