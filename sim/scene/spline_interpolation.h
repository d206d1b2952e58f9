// Control points of splines through images of points.
#pragma once

#include <Eigen/Core>

#include "sim/scene/spline_axis.h"

namespace weft::sim {

// Returns the control points of the curves through the points of images: the product of
// SplineAxis::interpolation() and `images`, without that matrix, which would not fit into memory
// for a long axis. An image is a column with a row per point, and so are control points. Takes time
// and memory in proportion to the size of `images`, because it solves banded systems.
Eigen::MatrixXd control_points_of(const SplineAxis& axis, const Eigen::MatrixXd& images);

}  // namespace weft::sim
