// The points of surfaces on which loads act.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// A point of a body's surface: a weighted sum of nodes_per_load_point() particles (local indices).
// The parameter u grows with the column of the image, v with the row. On an edge, u runs along the
// edge and v into the surface. a_u x a_v always has the direction of the surface's normal.
struct LoadPoint {
  SplineSurface::Point at;
  double measure = 1;  // length (m) or area (m^2) at rest that belongs to the point; 1 for a vertex
  // Area (m^2) at rest per parameter area, for points of the surface. The parameter area that
  // belongs to the point is measure / area_factor.
  double area_factor = 1;
};

// Returns the number of particles per load point. Cloth has 4: each cell is interpolated between
// its corners. A shell has the control points of an element.
int nodes_per_load_point(const SceneBody& body);

// Returns the points on which a load acts: the selected vertices, two Gauss points per segment of
// each edge, or four per cell of the surface. `positions` has the particles of the body at the
// start, m; a box of the load selects points by their places there. Throws CaseError at the load if
// it selects nothing, or an edge that the surface does not have because it is closed.
std::vector<LoadPoint> find_load_points(const SceneBody& body, const LoadCase& load,
                                        std::span<const Vec3> positions);

}  // namespace weft::sim
