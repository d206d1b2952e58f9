// The view of a camera or a light, and the perspective that projects the view on a picture.
#pragma once

#include <Eigen/Core>

#include "gpu/renderer.h"

namespace weft::gpu {

// The directions right, up and backward of a camera, in world coordinates; orthonormal.
struct ViewFrame {
  Vec3 right, up, backward;
};

// Returns the frame of a camera that looks in the direction opposite to `backward`. `up` may be any
// direction, even parallel to `backward`. Precondition: neither is zero.
ViewFrame look_along(const Vec3& backward, const Vec3& up);

// The perspective of a camera. Positions are relative to the camera's target. Pixels are counted
// from the upper left corner of the picture, x to the right, y downwards.
struct Perspective {
  ViewFrame frame;
  Vec3 eye;             // m
  int width, height;    // pixels
  double focal_length;  // pixels
  double nearest;       // m; smallest distance from the eye, along the camera's axis, that is drawn

  // Returns the coordinates of a point relative to the eye: right, up and forward, m.
  Vec3 seen(const Vec3& position) const {
    const Vec3 ray = position - eye;
    return {frame.right.dot(ray), frame.up.dot(ray), -frame.backward.dot(ray)};
  }
  // Returns the pixel position of a point in front of the eye.
  Eigen::Vector2d pixel(const Vec3& seen_point) const {
    const double scale = focal_length / seen_point.z();
    return {0.5 * width + scale * seen_point.x(), 0.5 * height - scale * seen_point.y()};
  }
};

}  // namespace weft::gpu
