// Triangles and lines as a camera sees them, prepared for drawing sample by sample.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gpu/triangle_batch.h"
#include "gpu/view.h"

namespace weft::gpu {

// A quantity that is linear in the picture: start + across * x + down * y. x and y are relative to
// the upper left pixel of its triangle or line, so that floats stay precise.
struct ScreenPlane {
  float start = 0, across = 0, down = 0;

  float at(float x, float y) const { return start + across * x + down * y; }
};

// The pixels that a triangle or a line may touch: columns left..right, rows top..bottom.
struct ScreenBox {
  int left = 0, top = 0, right = -1, bottom = -1;
};

struct ScreenTriangle {
  ScreenBox box;
  // Barycentric coordinates in the picture (shares), one per corner. A point is inside if no share
  // is below -slack, which allows for rounding. The barycentric coordinates in space are
  // proportional to the shares times the nearness of their corners.
  std::array<ScreenPlane, 3> shares;
  std::array<float, 3> slack;
  // Reciprocal of the distance from the eye along the line of sight, 1/m.
  ScreenPlane nearness;
  std::array<float, 3> corner_nearness;
  std::array<std::uint32_t, 3> corners;
  std::uint32_t surface;
  bool is_front;
};

// A line one pixel wide.
struct ScreenLine {
  ScreenBox box;
  ScreenPlane along;                       // 0 at its tail to 1 at its head
  ScreenPlane aside;                       // pixels from its centre line
  float nearness = 0, nearness_slope = 0;  // 1/m: at the tail, and head less tail
  float darkness = 0, darkness_slope = 0;  // share of the light that it takes away, 0..1
};

struct ScreenGeometry {
  std::vector<ScreenTriangle> triangles;
  std::vector<ScreenLine> lines;

  // Replaces the contents by the part of the batch that the picture shows. Triangles that are large
  // in the picture are cut into smaller ones, so that lighting their corners is enough. The new
  // vertices are appended to the batch. O(vertices + triangles + pixels / 100).
  void project(const Perspective& perspective, TriangleBatch& batch);
};

}  // namespace weft::gpu
