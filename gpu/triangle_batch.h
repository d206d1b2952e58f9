// The surfaces of one picture as one list of vertices, one of triangles and one of lines.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/renderer.h"

namespace weft::gpu {

// A vertex. Its values are one vector, because they are interpolated together. The normal is a unit
// vector, or zero if undefined. At a vertex that ScreenGeometry::project() adds, it may be shorter.
struct BatchVertex {
  Eigen::Array<float, 8, 1> values;

  auto position() const { return values.head<3>(); }  // m, relative to the batch's origin
  auto normal() const { return values.segment<3>(3); }
  // The sky's light on the side to which the normal points, and on the other side
  // (gpu/sky_light.h).
  float& front_sky() { return values[6]; }
  float& back_sky() { return values[7]; }
};

struct BatchTriangle {
  std::array<std::uint32_t, 3> corners;
  std::uint32_t surface;  // index of its DrawnSurface
};

struct TriangleBatch {
  std::vector<BatchVertex> vertices;
  // DrawnSurface::places by vertex; 0 on surfaces without a map. Empty if no surface has a map.
  std::vector<float> places;
  std::vector<BatchTriangle> triangles;
  std::vector<std::array<std::uint32_t, 2>> lines;

  // Replaces the contents by these surfaces, without the light of the sky. Positions become
  // relative to `origin` (m). O(vertices + triangles).
  void assemble(std::span<const DrawnSurface> surfaces, const Vec3& origin);
};

// Returns unit normals by vertex: the normalised sum of the area vectors of the surrounding
// triangles, or zero if that sum is zero.
std::vector<Vec3> vertex_normals(const DrawnSurface& surface);
// Returns the normals of the original surface at the vertices of a surface of reduced detail. With
// these normals, the reduced surface is lit like the original. O(triangles of the original).
std::vector<Vec3> detail_normals(const bsi::DetailSurface& detail, const DrawnSurface& original);

}  // namespace weft::gpu
