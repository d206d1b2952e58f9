// The smallest ball that holds a set of points.
#pragma once

#include <span>

#include "bsi/geometry_image.h"

namespace weft::bsi {

struct Ball {
  Vec3 centre = Vec3::Zero();
  double squared_radius = 0;
};

// Smallest ball of the points (at least one) to within rounding: every point lies inside the ball
// of its centre whose radius is larger by a factor of 1 + 1e-12, and no ball is smaller by more.
// The ball is that of at most four of the points, its support. As long as a point lies outside the
// ball of the support, the farthest such point joins it, and the support shrinks to the points that
// the smallest ball of these at most five rests on; so the ball grows in every step, and no support
// comes twice (the pivot rule of B. Gaertner, "Fast and robust smallest enclosing balls", ESA 1999,
// LNCS 1643, section 3; the balls of up to four points are solved for directly). In practice a
// dozen passes over the points.
Ball smallest_ball(std::span<const Vec3> points);

}  // namespace weft::bsi
