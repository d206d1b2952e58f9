// Triangles and lines as a camera sees them, ready to be drawn sample by sample.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gpu/triangle_batch.h"
#include "gpu/view.h"

namespace weft::gpu {

// A quantity that is linear in the picture: start + across * x + down * y. Its x and y are relative
// to the upper left pixel of the triangle or line it belongs to, where floats are precise.
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
  // Shares of the corners in a point of the picture; a point is inside where no share is below
  // -slack, which makes up for rounding. In space a share counts in proportion to the corner's
  // nearness.
  std::array<ScreenPlane, 3> shares;
  std::array<float, 3> slack;
  // The reciprocal of the distance from the eye, along the line of sight, 1/m.
  ScreenPlane nearness;
  std::array<float, 3> corner_nearness;
  std::array<std::uint32_t, 3> corners;
  std::uint32_t surface;
  bool is_front;
};

// A line one pixel wide.
struct ScreenLine {
  ScreenBox box;
  ScreenPlane along;                       // 0..1 from its tail to its head
  ScreenPlane aside;                       // pixels from its middle
  float nearness = 0, nearness_slope = 0;  // 1/m, at the tail, and what the head has more
  float darkness = 0, darkness_slope = 0;  // share of the light it takes away, 0..1
};

struct ScreenGeometry {
  std::vector<ScreenTriangle> triangles;
  std::vector<ScreenLine> lines;

  // Replaces the contents by what of the batch is in the picture. Triangles that are large in it
  // are cut into smaller ones, so that light at their corners is enough; the vertices this takes
  // are appended to the batch. O(vertices + triangles + pixels / 100).
  void project(const Perspective& perspective, TriangleBatch& batch);
};

}  // namespace weft::gpu
