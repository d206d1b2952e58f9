// Triangles and lines as a camera sees them, prepared for drawing sample by sample.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gpu/triangle_batch.h"
#include "gpu/view.h"

namespace weft::gpu {

// A quantity that is linear in the picture: start + across * x + down * y. x and y (pixels) are
// counted from the upper left corner of a ScreenBox, which keeps floats precise.
struct ScreenPlane {
  float start = 0, across = 0, down = 0;

  float at(float x, float y) const { return start + across * x + down * y; }
};

// The pixels that a triangle or a line may touch: columns left..right and rows top..bottom, both
// ends included.
struct ScreenBox {
  int left = 0, top = 0, right = -1, bottom = -1;
};

struct ScreenTriangle {
  ScreenBox box;
  // The barycentric coordinates in the picture, one per corner. Each coordinate, multiplied by the
  // nearness of its corner, is proportional to the barycentric coordinate in space.
  std::array<ScreenPlane, 3> shares;
  // A point is inside the triangle if no barycentric coordinate is below -slack. The slack allows
  // for rounding.
  std::array<float, 3> slack;
  // Reciprocal of the distance from the eye, measured along the camera's axis, 1/m.
  ScreenPlane nearness;
  std::array<float, 3> corner_nearness;
  std::array<std::uint32_t, 3> corners;
  std::uint32_t surface;
  bool is_front;
};

// A line one pixel wide.
struct ScreenLine {
  ScreenBox box;
  ScreenPlane along;  // position along the line: 0 at its tail, 1 at its head
  ScreenPlane aside;  // signed distance from the centre line, pixels
  // Nearness at the tail, and its increase from tail to head, 1/m.
  float nearness = 0, nearness_slope = 0;
  // Fraction of the light that the line absorbs at its tail (0..1), and the increase to its head.
  float darkness = 0, darkness_slope = 0;
};

struct ScreenGeometry {
  std::vector<ScreenTriangle> triangles;
  std::vector<ScreenLine> lines;

  // Replaces the contents by the part of the batch that the picture shows. Triangles that are large
  // in the picture are cut into smaller triangles, because the light of the sky is computed only at
  // corners. The new vertices are appended to the batch. O(vertices + triangles + pixels / 100).
  void project(const Perspective& perspective, TriangleBatch& batch);
};

}  // namespace weft::gpu
