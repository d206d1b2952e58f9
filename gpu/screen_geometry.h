// Triangles and lines as a camera sees them, ready to be drawn sample by sample.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gpu/triangle_batch.h"
#include "gpu/view.h"

namespace weft::gpu {

// A quantity that is linear in the picture: start + across * x + down * y. x and y are relative to
// the upper left pixel of its triangle or line, which keeps floats precise.
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
  // Barycentric shares of the corners at a point of the picture. A point is inside if no share is
  // below -slack, which allows for rounding. Barycentric coordinates in space are proportional to
  // the shares times the nearness of their corners.
  std::array<ScreenPlane, 3> shares;
  std::array<float, 3> slack;
  // Reciprocal of the distance from the eye, along the line of sight, 1/m.
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
  float nearness = 0, nearness_slope = 0;  // 1/m, at the tail, and its difference to the head
  float darkness = 0, darkness_slope = 0;  // share of the light it takes away, 0..1
};

struct ScreenGeometry {
  std::vector<ScreenTriangle> triangles;
  std::vector<ScreenLine> lines;

  // Replaces the contents by the part of the batch that the picture shows. Triangles that are large
  // in the picture are cut into smaller ones, so light at their corners is enough; the new vertices
  // are appended to the batch. O(vertices + triangles + pixels / 100).
  void project(const Perspective& perspective, TriangleBatch& batch);
};

}  // namespace weft::gpu
