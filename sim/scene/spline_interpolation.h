// Control points of splines through images of points.
#pragma once

#include <Eigen/Core>

#include "sim/scene/spline_axis.h"

namespace weft::sim {

// Returns the control points of the curves through the points of images. An image is a column with
// a row per point, and so are control points. If not SplineAxis::passes_through_image(), the curve
// passes the image's points at a distance of order 4 in their spacing, its end points excepted.
// Polynomials of the spline's degree are reproduced in any case. Takes time and memory in
// proportion to the size of `images`, because it solves banded systems.
Eigen::MatrixXd control_points_of(const SplineAxis& axis, const Eigen::MatrixXd& images);

}  // namespace weft::sim
