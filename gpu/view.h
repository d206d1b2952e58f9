// The view of a camera or a light, and the perspective that lays it on a picture.
#pragma once

#include <Eigen/Core>

#include "gpu/renderer.h"

namespace weft::gpu {

// Right, up and backward, as the camera sees them, in world coordinates; orthonormal.
struct ViewFrame {
  Vec3 right, up, backward;
};

// Returns the frame that looks against `backward`; `up` may be any direction, even that of the
// view.
ViewFrame look_along(const Vec3& backward, const Vec3& up);

// The perspective of a camera. Positions are relative to its target; pixels are counted from the
// upper left corner of the picture, x to the right, y downwards.
struct Perspective {
  ViewFrame frame;
  Vec3 eye;             // m
  int width, height;    // pixels
  double focal_length;  // pixels
  double nearest;       // m; what is nearer to the eye is cut off

  // Right, up and forward of the eye, m.
  Vec3 seen(const Vec3& position) const {
    const Vec3 ray = position - eye;
    return {frame.right.dot(ray), frame.up.dot(ray), -frame.backward.dot(ray)};
  }
  // Returns where in the picture a point in front of the eye is, in pixels.
  Eigen::Vector2d pixel(const Vec3& seen_point) const {
    const double scale = focal_length / seen_point.z();
    return {0.5 * width + scale * seen_point.x(), 0.5 * height - scale * seen_point.y()};
  }
};

}  // namespace weft::gpu
