// Points of surfaces on which loads act.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// A point of a body's surface on which a load acts. It is a weighted sum of nodes_per_load_point()
// particles (local indices). At an edge load, the parameter u runs along the edge and v into the
// surface. At other loads, u grows with the column of the image, and v with the row. a_u x a_v has
// the direction of the surface's normal.
struct LoadPoint {
  SplineSurface::Point at;
  double measure = 1;  // length (m) or area (m^2) at rest that the point stands for; 1 for a vertex
  // Area (m^2) at rest per parameter area, for loads on areas. The point stands for the parameter
  // area measure / area_factor. 1 for other loads.
  double area_factor = 1;
};

// Returns the number of particles on which a load point depends. For cloth it is 4, because a point
// is interpolated between the corners of its cell. For a shell it is the number of control points
// of an element.
int nodes_per_load_point(const SceneBody& body);

// Returns the points on which a load acts: the selected vertices, two Gauss points per segment of
// each selected edge, or four Gauss points per cell of the surface. If a load on an area has a box,
// points outside the box are left out. `positions` has the positions of the body's particles at t =
// 0 (m), with which the box is compared. Throws CaseError at the load if it selects nothing, or an
// edge that the surface does not have because it is closed.
std::vector<LoadPoint> find_load_points(const SceneBody& body, const LoadCase& load,
                                        std::span<const Vec3> positions);

}  // namespace weft::sim
